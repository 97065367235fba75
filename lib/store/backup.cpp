
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "base/error.h"
#include "store/atomic_file.h"

namespace surveymc::store {
namespace {

namespace fs = std::filesystem;

fs::path numbered(const fs::path& target, int number) {
  const bool is_part = target.extension() == ".part";
  const std::string name = is_part
                               ? fmt::format("{}.{}", target.filename().string(), number)
                               : fmt::format("{}.{}{}", target.stem().string(), number, target.extension().string());
  return target.parent_path() / name;
}

[[noreturn]] void refuse(const fs::path& target, const fs::path& kept, int reason) {
  throw IoError(fmt::format("{}: exists and cannot be kept as {}: {}", target.string(), kept.string(),
                            std::generic_category().message(reason)));
}

/// How the old file got its second name.
struct Kept {
  fs::path name = {};
  bool moved = false;  // the file system has no second names
  bool ours = false;   // not the second name that a killed attempt gave it
};

Kept keep(const fs::path& target) {
  std::error_code error;
  const fs::file_type type = fs::status(target, error).type();
  if (type == fs::file_type::none)  // the system does not say: it may be a result, which write() would replace
    throw IoError(fmt::format("{}: cannot be looked at: {}", target.string(), error.message()));
  if (type != fs::file_type::regular) return {};  // nothing, or what write() refuses
  for (int number = 1;; ++number) {
    const fs::path name = numbered(target, number);
    if (link(target.c_str(), name.c_str()) == 0) return {name, false, true};
    if (errno == EEXIST) {
      if (fs::equivalent(target, name, error)) return {name};
      continue;
    }
    if (errno == ENOSPC || errno == EDQUOT || errno == EROFS || errno == ENAMETOOLONG) refuse(target, name, errno);
    if (std::rename(target.c_str(), name.c_str()) != 0)
      refuse(target, name, errno);  // link() has shown that it is free
    return {name, true, true};
  }
}

}  // namespace

fs::path write_beside_old(const fs::path& path, bool overwrite, const std::function<void()>& write) {
  const fs::path target = resolved(path);
  const Kept kept = overwrite ? Kept{} : keep(target);
  try {
    write();
  } catch (...) {
    // The new file may have its name already, as the disk can fail after that: then the old one keeps its new name.
    std::error_code error;
    if (kept.moved && fs::status(target, error).type() == fs::file_type::not_found)
      std::rename(kept.name.c_str(), target.c_str());
    if (kept.ours && !kept.moved && fs::equivalent(target, kept.name, error)) unlink(kept.name.c_str());
    throw;
  }
  return kept.name.lexically_normal();
}

}  // namespace surveymc::store
