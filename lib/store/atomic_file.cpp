#include "store/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace surveymc::store {
namespace {

namespace fs = std::filesystem;

/// The part of the name before "<pid>.tmp". It includes the host, because pids mean nothing on another host.
std::string temporary_prefix(const fs::path& target) {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host = {"localhost"};
  return fmt::format(".{}.{}.", target.filename().string(), host.data());
}

constexpr std::string_view kTemporarySuffix = ".tmp";

[[noreturn]] void fail() { throw std::system_error(errno, std::generic_category()); }

}  // namespace

fs::path resolved(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as the kernel; a ring of links ends here and fails when it is opened
  std::error_code error;
  fs::path target = path;
  for (int i = 0; i < kMostLinks && fs::is_symlink(target, error); ++i) {
    const fs::path next = fs::read_symlink(target, error);
    if (error) return path;
    target = next.is_absolute() ? next : folder_of(target) / next;
  }
  return target;
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

void remove_stale_temporaries(const fs::path& target) {
  const std::string prefix = temporary_prefix(target);
  std::error_code error;
  for (fs::directory_iterator it(folder_of(target), error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    const std::size_t around = prefix.size() + kTemporarySuffix.size();
    if (!name.starts_with(prefix) || !name.ends_with(kTemporarySuffix) || name.size() <= around) continue;
    const std::string pid = name.substr(prefix.size(), name.size() - around);
    const bool is_number = pid.size() <= 9 && pid[0] != '0' && pid.find_first_not_of("0123456789") == std::string::npos;
    if (is_number && kill(std::stoi(pid), 0) != 0 && errno == ESRCH) unlink(it->path().c_str());
  }
}

AtomicFile::AtomicFile(const fs::path& target)
    : target_(target),
      path_(folder_of(target) / fmt::format("{}{}{}", temporary_prefix(target), getpid(), kTemporarySuffix)) {
  unlink(path_.c_str());  // no living process but this one has our pid, so this is a dead writer's
  file_ = open(path_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file_ < 0) fail();
}

AtomicFile::~AtomicFile() {
  if (file_ >= 0) close(file_);
  if (!committed_) unlink(path_.c_str());
}

void AtomicFile::write(const std::vector<char>& bytes) {
  constexpr std::size_t kMost = std::size_t{1} << 30;  // one write() takes less than 2^31 bytes
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::write(file_, bytes.data() + done, std::min(bytes.size() - done, kMost));
    if (n < 0 && errno != EINTR) fail();
    if (n > 0) done += static_cast<std::size_t>(n);
  }
}

void AtomicFile::commit() {
  if (fsync(file_) != 0) fail();
  if (close(std::exchange(file_, -1)) != 0) fail();
  if (rename(path_.c_str(), target_.c_str()) != 0) fail();
  committed_ = true;
  const int folder = open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;  // a folder that we may write but not read: its entry reaches the disk a little later
  const bool failed = fsync(folder) != 0 && errno == EIO;  // other errors: a file system without fsync of folders
  close(folder);
  if (failed) throw std::system_error(EIO, std::generic_category());
}

}  // namespace surveymc::store
