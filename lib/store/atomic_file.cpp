#include "store/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "base/error.h"
#include "base/retry.h"

namespace surveymc::store {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".tmp";
constexpr std::size_t kRandomDigits = 16;

std::string temporary_prefix(const fs::path& target) { return fmt::format(".{}.", target.filename().string()); }

bool is_temporary_of(const std::string& name, const std::string& prefix) {
  if (name.size() != prefix.size() + kRandomDigits + kSuffix.size()) return false;
  const std::string_view digits = std::string_view(name).substr(prefix.size(), kRandomDigits);
  return name.starts_with(prefix) && name.ends_with(kSuffix) &&
         digits.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::mutex g_files_mutex;
AtomicFile* g_newest_file = nullptr;  // a list by older_, which needs no memory

[[noreturn]] void fail() { throw std::system_error(errno, std::generic_category()); }

fs::path temporary_name(const fs::path& target) {
  std::uint64_t number = 0;
  if (getrandom(&number, sizeof number, 0) != static_cast<ssize_t>(sizeof number)) fail();
  return folder_of(target) / fmt::format("{}{:016x}{}", temporary_prefix(target), number, kSuffix);
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::equivalent(a, b, error);
}

/// True of a file system that does not know the flags of renameat2(), as NFS.
bool lacks_flags(int error) { return error == EINVAL || error == ENOSYS; }

/// Gives the file another name if that is free; false if it is not.
bool move_if_free(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno == EEXIST) return false;
  if (!lacks_flags(errno)) fail();
  if (link(from.c_str(), to.c_str()) == 0) {
    if (unlink(from.c_str()) != 0) fail();
    return true;
  }
  struct stat there {};
  if (errno == EEXIST || lstat(to.c_str(), &there) == 0) return false;
  if (rename(from.c_str(), to.c_str()) != 0) fail();  // no second names either (exFAT)
  return true;
}

fs::path numbered(const fs::path& target, int number) {
  const bool is_part = target.extension() == ".part";
  const std::string name = is_part
                               ? fmt::format("{}.{}", target.filename().string(), number)
                               : fmt::format("{}.{}{}", target.stem().string(), number, target.extension().string());
  return target.parent_path() / name;
}

/// Gives the file the next free number.
fs::path move_aside(const fs::path& file, const fs::path& target) {
  int number = 1;
  while (!move_if_free(file, numbered(target, number))) ++number;
  return numbered(target, number);
}

struct SecondName {
  fs::path name;
  bool is_moved = false;  ///< the file system has no second names: the file has lost its own
  bool is_new = false;    ///< not the second name that a killed or another writer has given it
};

/// Nothing if there is no file any more.
std::optional<SecondName> second_name(const fs::path& target) {
  for (int number = 1;; ++number) {
    const fs::path name = numbered(target, number);
    if (link(target.c_str(), name.c_str()) == 0) return SecondName{name, false, true};
    if (errno == ENOENT) return std::nullopt;
    if (errno == EEXIST) {
      if (is_same_file(target, name)) return SecondName{name};
      continue;
    }
    int reason = errno;
    if (reason != ENOSPC && reason != EDQUOT && reason != EROFS && reason != ENAMETOOLONG) try {
        if (move_if_free(target, name)) return SecondName{name, true, true};
        continue;
      } catch (const std::system_error& e) {
        if (e.code().value() == ENOENT) return std::nullopt;
        reason = e.code().value();
      }
    throw IoError(fmt::format("{}: exists and cannot be kept as {}: {}", target.string(), name.string(),
                              std::generic_category().message(reason)));
  }
}

bool allows(const MayReplace& may_replace, const fs::path& file) {
  try {
    if (may_replace) may_replace(file);
    return true;
  } catch (const IoError&) {
    return false;
  }
}

}  // namespace

fs::path resolved(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as the kernel; a ring of links ends here, and the file takes the place of one
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

void look_at(const fs::path& path, const MayReplace& look) {
  for (;;) {
    struct stat before {};
    struct stat after {};
    const bool was_there = stat(path.c_str(), &before) == 0;
    try {
      return look(path);
    } catch (const IoError&) {
      const bool is_there = stat(path.c_str(), &after) == 0;
      if (was_there == is_there && before.st_ino == after.st_ino && before.st_dev == after.st_dev) throw;
    }
  }
}

void remove_stale_temporaries(const fs::path& target) {
  const std::string prefix = temporary_prefix(target);
  std::error_code error;
  for (fs::directory_iterator it(folder_of(target), error), end; !error && it != end; it.increment(error)) {
    if (!is_temporary_of(it->path().filename().string(), prefix)) continue;
    const int file = open(it->path().c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) continue;
    if (flock(file, LOCK_EX | LOCK_NB) == 0) unlink(it->path().c_str());
    close(file);
  }
}

AtomicFile::AtomicFile(const fs::path& target) : target_(target) {
  // Another process may take the new file for a dead writer's before it is locked: then there is a next one.
  constexpr int kAttempts = 100;
  for (int i = 0; i < kAttempts && file_ < 0; ++i) {
    path_ = temporary_name(target);
    file_ =
        uninterrupted([&] { return open(path_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_EXCL | O_CLOEXEC, 0666); });
    if (file_ < 0 && errno != EEXIST) fail();
    if (file_ < 0) continue;
    const bool is_taken = flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;  // no locks here: as if locked
    struct stat status {};
    if (!is_taken && fstat(file_, &status) == 0 && status.st_nlink > 0) break;
    unlink(path_.c_str());  // who has taken it would do that
    close(std::exchange(file_, -1));
  }
  if (file_ < 0) fail();
  const std::lock_guard lock(g_files_mutex);
  older_ = std::exchange(g_newest_file, this);
}

void AtomicFile::remove_all() {
  const std::lock_guard lock(g_files_mutex);
  for (const AtomicFile* f = g_newest_file; f; f = f->older_)
    if (!f->committed_) unlink(f->path_.c_str());
}

AtomicFile::~AtomicFile() {
  {
    const std::lock_guard lock(g_files_mutex);
    AtomicFile** at = &g_newest_file;
    while (*at != this) at = &(*at)->older_;
    *at = older_;
  }
  if (file_ >= 0) close(file_);
  if (!committed_) unlink(path_.c_str());
}

void AtomicFile::write(std::span<const char> bytes) {
  constexpr std::size_t kMost = std::size_t{1} << 30;  // one write() takes less than 2^31 bytes
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n =
        uninterrupted([&] { return ::write(file_, bytes.data() + done, std::min(bytes.size() - done, kMost)); });
    if (n < 0) fail();
    done += static_cast<std::size_t>(n);
  }
}

void AtomicFile::set_committed(bool committed) {
  const std::lock_guard lock(g_files_mutex);
  committed_ = committed;
}

/// The new file has its name, and the old one the temporary name; false if there is no old one any more. Where the
/// system cannot exchange two names the old file has none then, and neither has the new one a temporary name.
bool AtomicFile::exchange_names() {
  set_committed(true);  // an end that removes temporary files must not take the old file for one
  if (renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) return true;
  if (lacks_flags(errno) && rename(path_.c_str(), target_.c_str()) == 0) return true;
  set_committed(false);
  if (errno != ENOENT) fail();
  return false;
}

void AtomicFile::take_name(OldFile old, const MayReplace& may_replace, std::vector<fs::path>& kept) {
  while (!move_if_free(path_, target_)) {
    if (old == OldFile::refused) throw std::system_error(EEXIST, std::generic_category());
    if (may_replace) may_replace(target_);
    std::optional<SecondName> second;
    if (old == OldFile::kept) {
      second = second_name(target_);
      if (!second) continue;
      if (second->is_moved) {
        kept.push_back(second->name);
        continue;
      }
    }
    try {
      if (!exchange_names()) continue;
    } catch (...) {
      if (second && second->is_new && is_same_file(second->name, target_)) unlink(second->name.c_str());
      throw;
    }
    if (second) kept.push_back(second->name);
    // It may be another file than the one that we looked at: somebody was faster. Then it is kept in any case.
    std::error_code error;
    if (!fs::exists(path_, error)) return;
    if (second ? is_same_file(path_, second->name) : allows(may_replace, path_))
      unlink(path_.c_str());
    else
      kept.push_back(move_aside(path_, target_));
    return;
  }
}

std::vector<fs::path> AtomicFile::commit(OldFile old, const MayReplace& may_replace) {
  // Who may read the old file may read the new one; where that cannot be set, the new file has the usual mode.
  if (struct stat there{}; stat(target_.c_str(), &there) == 0 && S_ISREG(there.st_mode)) {
    const bool is_set = fchmod(file_, there.st_mode & 07777) == 0;
    (void)is_set;
  }
  if (uninterrupted([&] { return fsync(file_); }) != 0) fail();
  std::vector<fs::path> kept;
  try {
    take_name(old, may_replace, kept);  // with the file still open: its lock lasts until it has its name
  } catch (...) {
    // Without second names an old file may have lost its own.
    if (std::error_code error; !kept.empty() && !fs::exists(target_, error))
      rename(kept.back().c_str(), target_.c_str());
    throw;
  }
  set_committed(true);
  for (fs::path& name : kept) name = name.lexically_normal();
  const int folder =
      uninterrupted([&] { return open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); });
  if (folder < 0) return kept;  // a folder that we may write but not read: its entry reaches the disk a little later
  const bool failed = uninterrupted([&] { return fsync(folder); }) != 0 &&
                      errno == EIO;  // other errors: a file system without fsync of folders
  close(folder);
  if (failed) throw std::system_error(EIO, std::generic_category());
  return kept;
}

}  // namespace surveymc::store
