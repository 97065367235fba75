#pragma once
#include <cerrno>

namespace surveymc {

/// The result of a system call that is made again as long as a signal interrupts it. Not for close(), whose descriptor
/// is gone in any case.
template <class Call>
auto uninterrupted(const Call& call) {
  for (;;) {
    const auto result = call();
    if (result >= 0 || errno != EINTR) return result;
  }
}

}  // namespace surveymc
