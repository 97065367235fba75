#include "store/isolated.h"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
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

constexpr int kTooLarge = 1;

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
  constexpr std::uintmax_t kSanitizer = std::uintmax_t{1} << 40;  // their shadow alone has terabytes
  std::uintmax_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const std::uintmax_t used = pages * static_cast<std::uintmax_t>(sysconf(_SC_PAGESIZE));
  if (used < kSanitizer) limit(RLIMIT_AS, used + kFree + kTimes * file_size);
  limit(RLIMIT_CPU, kSeconds + file_size / kBytesPerSecond);
  limit(RLIMIT_CORE, 0);
}

[[noreturn]] void be_child(std::uintmax_t file_size, const std::function<void()>& work) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU}) std::signal(signal, SIG_DFL);
  limit_child(file_size);
  int exit = 0;
  try {
    work();
  } catch (const std::bad_alloc&) {
    exit = kTooLarge;
  } catch (...) {
  }
  _exit(exit);
}

}  // namespace

std::string harm_in_child(std::uintmax_t file_size, const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) be_child(file_size, work);
  int status = 0;
  if (child < 0 || uninterrupted([&] { return waitpid(child, &status, 0); }) < 0)
    throw std::system_error(errno, std::generic_category());
  if (WIFEXITED(status)) return WEXITSTATUS(status) == 0 ? "" : "is too large for the memory, or damaged";
  const int signal = WTERMSIG(status);
  return "is damaged, or made to do harm: " +
         (signal == SIGXCPU ? std::string("reading it takes too long")
                            : fmt::format("reading it ends with signal {} ({})", signal, strsignal(signal)));
}

}  // namespace surveymc::store
