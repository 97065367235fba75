#pragma once
/// Which files are read as input. Pipes, devices and sockets may never end, or wait for ever.
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>

#include <sys/stat.h>

#include <fmt/format.h>

namespace surveymc {

/// Why the file cannot be read: it is missing, a folder, no regular file, or larger than `most` bytes (0: no limit).
/// Empty if it can be read. `way_out`: what to do about a file that is too large.
inline std::string input_fault(const std::filesystem::path& path, std::uint64_t most = 0,
                               const std::string& way_out = "") {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return std::generic_category().message(errno);
  if (S_ISDIR(status.st_mode)) return "it is a folder";
  if (!S_ISREG(status.st_mode)) return "it is a pipe or a device: save what it gives as a file, and name that";
  const auto size = static_cast<std::uint64_t>(status.st_size);
  constexpr double kMebi = 1048576;
  if (most > 0 && size > most)
    return fmt::format("it has {:.0f} MiB, at most {:.0f} are read: {}", static_cast<double>(size) / kMebi,
                       static_cast<double>(most) / kMebi, way_out);
  return "";
}

}  // namespace surveymc
