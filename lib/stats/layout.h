#pragma once
/// Names for ranges of numbers in one row: the meaning of each of a tally's counts, groups, moments or samples.
///
///   struct Events : Layout {
///     Events(std::size_t errors, std::size_t methods) : found(slots(errors)), outcome(slots(methods, 5)) {}
///     Slots found, outcome;   // in the order in which they are initialised
///   };
///   counts.assign(events.size(), 0);  ++counts[events.outcome(method, which)];
#include <cstddef>

namespace surveymc::stats {

/// Numbers first .. first + n - 1, by one, two or three indices, the last one fastest.
struct Slots {
  std::size_t first = 0, second_size = 1, third_size = 1;

  constexpr std::size_t operator()(std::size_t i = 0, std::size_t j = 0, std::size_t k = 0) const {
    return first + (i * second_size + j) * third_size + k;
  }
};

class Layout {
 public:
  /// Number of numbers in all ranges.
  constexpr std::size_t size() const { return size_; }
  /// The next n * m * l numbers.
  constexpr Slots slots(std::size_t n = 1, std::size_t m = 1, std::size_t l = 1) {
    const Slots r{size_, m, l};
    size_ += n * m * l;
    return r;
  }

 private:
  std::size_t size_ = 0;
};

}  // namespace surveymc::stats
