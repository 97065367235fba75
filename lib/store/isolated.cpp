#include "store/isolated.h"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <new>
#include <system_error>

#include <fmt/format.h>

#include "base/retry.h"

namespace surveymc::store {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SURVEYMC_SHADOWED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SURVEYMC_SHADOWED
#endif
#endif

#if defined(SURVEYMC_SHADOWED)
constexpr bool kLimitsMemory = false;  // the sanitizer's shadow alone has terabytes
#else
constexpr bool kLimitsMemory = true;
#endif

void limit(decltype(RLIMIT_AS) resource, std::uintmax_t most) {
  rlimit now{};
  if (getrlimit(resource, &now) != 0) return;
  now.rlim_cur = std::min<rlim_t>(now.rlim_max, most);
  setrlimit(resource, &now);
}

/// Far above what a file written by any version takes: compressed by others, its values have some times its size.
void limit_child(std::uintmax_t file_size) {
  constexpr std::uintmax_t kFree = std::uintmax_t{2} << 30, kTimes = 16;
  constexpr std::uintmax_t kSeconds = 5, kBytesPerSecond = 10'000'000;
  std::uintmax_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const auto page = static_cast<std::uintmax_t>(sysconf(_SC_PAGESIZE));
  if (kLimitsMemory) limit(RLIMIT_AS, pages * page + kFree + kTimes * file_size);
  limit(RLIMIT_CPU, kSeconds + file_size / kBytesPerSecond);
  limit(RLIMIT_CORE, 0);
}

void tell(int pipe, const char* text) { [[maybe_unused]] const ssize_t n = write(pipe, text, std::strlen(text)); }

[[noreturn]] void be_child(int pipe, std::uintmax_t file_size, const std::function<void()>& work) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU}) std::signal(signal, SIG_DFL);
  limit_child(file_size);
  int exit = 1;
  try {
    work();
    exit = 0;
  } catch (const std::bad_alloc&) {
    tell(pipe, "is too large for the memory, or damaged");
  } catch (const std::exception& e) {
    tell(pipe, e.what());
  }
  _exit(exit);
}

[[noreturn]] void no_child() { throw std::system_error(errno, std::generic_category()); }

}  // namespace

std::string fault_in_child(std::uintmax_t file_size, const std::function<void()>& work) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) no_child();
  const pid_t child = fork();
  if (child < 0) {
    const int reason = errno;
    close(ends[0]);
    close(ends[1]);
    errno = reason;
    no_child();
  }
  if (child == 0) be_child(ends[1], file_size, work);
  close(ends[1]);
  std::string text;
  std::array<char, 4096> piece{};
  for (ssize_t n = 0; (n = uninterrupted([&] { return read(ends[0], piece.data(), piece.size()); })) > 0;)
    text.append(piece.data(), static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  if (uninterrupted([&] { return waitpid(child, &status, 0); }) < 0) no_child();
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return signal == SIGXCPU ? "is damaged, or made to do harm: reading it takes too long"
                             : fmt::format("is damaged, or made to do harm: reading it ends with signal {} ({})",
                                           signal, strsignal(signal));
  }
  if (WEXITSTATUS(status) == 0) return "";
  return text.empty() ? "cannot be read" : text;
}

}  // namespace surveymc::store
