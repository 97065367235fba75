#include "cli/new_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "base/small_letters.h"
#include "render/text.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::error_code& reason) {
  throw IoError(fmt::format("{}: cannot be written: {}", path.string(), reason.message()));
}

/// While it lives, no other command that writes files together gives names in this folder: the files of two would be
/// mixed. Without locks there, it does nothing.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder) : file_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (file_ >= 0) (void)flock(file_, LOCK_EX);
  }
  ~FolderLock() {
    if (file_ >= 0) close(file_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_;
};

}  // namespace

void NewFiles::add(const fs::path& path, const std::string& text, const How& how) {
  const fs::path target = how.follows_link ? store::resolved(path) : path;
  try {
    store::remove_stale_temporaries(target);
    File& f = files_.emplace_back(path, how, std::make_unique<store::AtomicFile>(target));
    f.file->write(text);
  } catch (const std::system_error& e) {
    fail(path, e.code());
  }
}

std::vector<fs::path> NewFiles::commit() {
  std::vector<fs::path> written;
  if (files_.empty()) return written;
  const FolderLock lock(store::folder_of(files_.back().path));
  for (const File& f : files_) try {
      f.file->commit(f.how.overwrite ? store::OldFile::replaced : store::OldFile::refused, [&](const fs::path& old) {
        std::error_code error;
        if (fs::symlink_status(old, error).type() != fs::file_type::regular)
          throw IoError(fmt::format("{}: exists and is no file that can be replaced: choose another name with -o",
                                    f.path.string()));
      });
      written.push_back(f.path);
    } catch (const std::system_error& e) {
      if (e.code() != std::errc::file_exists) fail(f.path, e.code());
      if (f.how.is_needed) throw IoError(fmt::format("{}: exists; choose another name with -o", f.path.string()));
    }
  return written;
}

std::string fault_of_input_name(const std::string& name) {
  // Of surveys, readings and tables, error models, geomagnetic models.
  constexpr std::array<std::string_view, 10> kEndings{".csv",  ".txt",  ".dat", ".tsv",  ".las",
                                                      ".xlsx", ".xlsm", ".xml", ".toml", ".cof"};
  if (name.find('\\') != std::string::npos || render::printable(name) != name)
    return "its name has characters that no name of an input has";
  if (fs::path(name).is_absolute()) return "its name is absolute";
  for (const fs::path& part : fs::path(name))
    if (part.empty() || part.native().front() == '.') return "a part of its name is empty or begins with a dot";
  const std::string ending = small_letters(fs::path(name).extension().string());
  if (std::find(kEndings.begin(), kEndings.end(), ending) == kEndings.end())
    return fmt::format("its name does not end as that of an input ({})", fmt::join(kEndings, " "));
  return "";
}

std::string make_folders(const fs::path& folder, const fs::path& name) {
  fs::path at = folder;
  for (const fs::path& part : name) {
    at /= part;
    std::error_code error;
    if (fs::is_symlink(at, error)) return fmt::format("{} is a link", at.string());
    if (at == folder / name) break;
    fs::create_directory(at, error);
    if (error) fail(at, error);
  }
  return "";
}

}  // namespace surveymc::cli
