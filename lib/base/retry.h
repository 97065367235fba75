#pragma once
#include <cerrno>
#include <type_traits>

namespace surveymc {

/// Repeats a call as long as a signal interrupts it, and returns its result, a number or a pointer. Not for close():
/// its descriptor is gone in any case.
template <class Call>
auto uninterrupted(const Call& call) {
  for (;;) {
    const auto result = call();
    bool is_done;
    if constexpr (std::is_pointer_v<decltype(call())>) {
      is_done = result != nullptr;
    } else {
      is_done = result >= 0;
    }
    if (is_done || errno != EINTR) return result;
  }
}

}  // namespace surveymc
