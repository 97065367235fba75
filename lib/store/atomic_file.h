#pragma once
/// Files that appear whole or not at all: written under a temporary name, renamed when they are complete.
#include <filesystem>
#include <vector>

namespace surveymc::store {

/// Where a symbolic link points: renaming onto the link would replace it and leave the file it names as it was.
std::filesystem::path resolved(const std::filesystem::path& path);

std::filesystem::path folder_of(const std::filesystem::path& path);

/// Removes what writers of `target` on this host left behind when they were killed.
void remove_stale_temporaries(const std::filesystem::path& target);

/// A file under its temporary name until commit(); gone if that is never reached.
/// The name is ".<name>.<host>.<pid>.tmp", in the folder of `target`. All throws std::system_error.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  void write(const std::vector<char>& bytes);  ///< behind what is there

  /// For another writer, which may replace the contents but not the file.
  const std::filesystem::path& temporary_path() const { return path_; }

  /// Makes it durable and gives it its name. After the rename nothing fails any more but the disk itself.
  void commit();

 private:
  std::filesystem::path target_, path_;
  int file_ = -1;
  bool committed_ = false;
};

}  // namespace surveymc::store
