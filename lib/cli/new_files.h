#pragma once
/// Files that a command writes together.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "store/atomic_file.h"

namespace surveymc::cli {

class NewFiles {
 public:
  /// Writes the file under a temporary name. `is_needed`: that there is one of the name already is an error; else that
  /// one stays. `follows_link`: if `path` is a link, where it leads is written, else no file is. Throws IoError.
  struct How {
    bool overwrite = false, is_needed = true, follows_link = false;
  };
  void add(const std::filesystem::path& path, const std::string& text, const How& how);

  /// Gives the files their names in the order in which they were added, and returns those that have them now. Throws
  /// IoError where a needed one exists; the files before it are there.
  std::vector<std::filesystem::path> commit();

 private:
  struct File {
    std::filesystem::path path;
    How how;
    std::unique_ptr<store::AtomicFile> file;
  };
  std::vector<File> files_;
};

/// Empty if the file of an input that a result stores may be written under `name`, in a folder of the user: the result
/// may be a stranger's. Else why not.
std::string fault_of_input_name(const std::string& name);

/// Makes the folders of the file `name` within `folder`. Empty, or that one of them or the file itself is a link: a
/// stranger may have planted it. Throws IoError where one cannot be made.
std::string make_folders(const std::filesystem::path& folder, const std::filesystem::path& name);

}  // namespace surveymc::cli
