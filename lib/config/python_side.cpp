#include "config/python_side.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <system_error>

#include <fmt/format.h>

#include "base/error.h"

namespace surveymc::config {
namespace {

namespace fs = std::filesystem;

/// scripts/surveymc beside the program: of the source tree that it was built in, or of its installation; or the package
/// that the program is part of (a wheel). Empty: not there.
fs::path python_folder() {
  std::error_code error;
  const fs::path folder = fs::path(own_path()).parent_path();
  for (const char* way : {"../scripts", "../../scripts", "../share/surveymc/scripts"}) {
    const fs::path path = (folder / way / "surveymc").lexically_normal();
    if (fs::is_regular_file(path / "__main__.py", error)) return path;
  }
  const fs::path native = folder.parent_path();
  if (native.filename() == "_native" && fs::is_regular_file(native / "../__main__.py", error))
    return native.parent_path();
  return {};
}

std::string python() {
  if (const char* named = std::getenv("SURVEYMC_PYTHON"); named && *named != '\0') return named;
  const auto runs = [](const fs::path& path) { return access(path.c_str(), X_OK) == 0; };
  if (constexpr const char* kDebian = "/usr/bin/python3"; runs(kDebian)) return kDebian;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const fs::path found = fs::path(folder) / "python3"; !folder.empty() && runs(found)) return found.string();
  return "";
}

}  // namespace

std::string own_path() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).string();
}

std::vector<std::string> python_command(const std::vector<std::string>& words) {
  const fs::path folder = python_folder();
  if (folder.empty())
    throw IoError(
        fmt::format("surveymc {}: is written in Python, and scripts/surveymc is not beside {}: install all of surveymc "
                    "(cmake --install), or take the program where it was built",
                    words.front(), own_path()));
  const std::string interpreter = python();
  if (interpreter.empty())
    throw IoError(
        fmt::format("surveymc {}: there is no python3: install it (Debian: sudo apt install python3), or name one in "
                    "the environment variable SURVEYMC_PYTHON",
                    words.front()));
  std::vector<std::string> command{interpreter, folder.string()};
  command.insert(command.end(), words.begin(), words.end());
  return command;
}

}  // namespace surveymc::config
