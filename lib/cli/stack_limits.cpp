#include "cli/stack_limits.h"

#include <pthread.h>
#include <sys/resource.h>

#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string_view>

#include <fmt/format.h>

namespace surveymc::cli {
namespace {

// The hungriest of the shipped configs takes 520 kB, most of them 90: Eigen keeps temporaries of up to 128 kB there.
constexpr std::uint64_t kLeast = 1 << 20, kKibibyte = 1 << 10;

/// Of "16k", " 2 M", "512" (kibibytes), as OpenMP reads it; none of what OpenMP does not take and passes over.
std::optional<std::uint64_t> openmp_bytes(std::string_view text) {
  const auto trim = [&] {
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front()))) text.remove_prefix(1);
  };
  trim();
  std::uint64_t size = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  trim();
  int shift = 10;
  if (!text.empty()) {
    constexpr std::string_view kUnits = "bkmg";
    const std::size_t unit = kUnits.find(static_cast<char>(std::tolower(static_cast<unsigned char>(text.front()))));
    if (unit == std::string_view::npos) return std::nullopt;
    shift = static_cast<int>(unit) * 10;
    text.remove_prefix(1);
    trim();
  }
  if (!text.empty() || size > UINT64_MAX >> shift) return std::nullopt;
  return size << shift;
}

std::string small_openmp_stacks() {
  for (const char* name : {"OMP_STACKSIZE", "GOMP_STACKSIZE"})
    if (const char* text = std::getenv(name))
      if (const std::optional<std::uint64_t> size = openmp_bytes(text); size && *size < kLeast)
        return fmt::format("{} = {}: the stacks of threads must have {} KiB at least: unset it, or give {}={}k", name,
                           text, kLeast / kKibibyte, name, kLeast / kKibibyte);
  return "";
}

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
  for (const auto fault : {small_openmp_stacks, small_main_stack, small_thread_stacks})
    if (const std::string text = fault(); !text.empty()) return text;
  return "";
}

}  // namespace surveymc::cli
