#include "cli/process_setup.h"

#include <pthread.h>
#include <sys/resource.h>

#include <cstdint>
#include <cstring>

#include <fmt/format.h>

namespace surveymc::cli {
namespace {

// The hungriest of the shipped configs takes 520 kB, most of them 90: Eigen keeps temporaries of up to 128 kB there.
constexpr std::uint64_t kLeast = 1 << 20, kKibibyte = 1 << 10;

std::string small_main_stack() {
  rlimit now{};
  if (getrlimit(RLIMIT_STACK, &now) != 0 || now.rlim_cur == RLIM_INFINITY || now.rlim_cur >= kLeast) return "";
  rlimit wanted = now;
  wanted.rlim_cur = kLeast;
  if ((now.rlim_max == RLIM_INFINITY || now.rlim_max >= kLeast) && setrlimit(RLIMIT_STACK, &wanted) == 0) return "";
  return fmt::format("the stack is limited to {} KiB (ulimit -s), and it must have {} at least: raise the limit",
                     now.rlim_max / kKibibyte, kLeast / kKibibyte);
}

/// The size of new threads is the limit that the process was started with.
std::string small_thread_stacks() {
#if defined(__GLIBC__)
  pthread_attr_t usual;
  std::size_t size = 0;
  if (pthread_getattr_default_np(&usual) != 0) return "";
  const bool is_small = pthread_attr_getstacksize(&usual, &size) == 0 && size < kLeast;
  int error = is_small ? pthread_attr_setstacksize(&usual, kLeast) : 0;
  if (is_small && error == 0) error = pthread_setattr_default_np(&usual);
  pthread_attr_destroy(&usual);
  if (error != 0)
    return fmt::format("the stacks of threads have {} KiB, and must have {} at least ({}): raise the limit (ulimit -s)",
                       size / kKibibyte, kLeast / kKibibyte, std::strerror(error));
#endif
  return "";
}

}  // namespace

std::string provide_stacks() {
  for (const auto fault : {small_main_stack, small_thread_stacks})
    if (const std::string text = fault(); !text.empty()) return text;
  return "";
}

}  // namespace surveymc::cli
