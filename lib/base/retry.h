#pragma once
#include <cerrno>
#include <type_traits>

namespace surveymc {

/// The result of a call, a number or a pointer, that is made again as long as a signal interrupts it. Not for close(),
/// whose descriptor is gone in any case.
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
