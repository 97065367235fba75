#pragma once
/// Extremes and median of the sizes |x| of many numbers, which come in pieces. Counts of disjoint pieces add up,
/// whoever has made them, to the same bits.
#include <cstddef>
#include <cstdint>
#include <vector>

namespace surveymc::stats {

/// Infinite numbers are counted apart, NaN not at all.
class SizeCounts {
 public:
  /// Keeps all finite sizes: its median is exact, as of stats::median().
  SizeCounts() = default;
  /// Counts sizes by their bit patterns, which have the order of the numbers: all by the upper 16 bits, and those
  /// within 3 percent of `expected` by the upper 32. Its median is the size of rank n / 2, to 1e-6 of itself.
  explicit SizeCounts(double expected);

  /// Numbers first, first + 1, ... of all.
  void add(const std::vector<double>& numbers, std::size_t first);
  /// `other`: of other numbers, made with the same arguments.
  void add(const SizeCounts& other);

  /// False: `expected` was too far away. Count all again, expecting what expected_median() says; that is near enough.
  bool has_median() const;
  double expected_median() const;
  /// NaN without finite sizes.
  double median() const;

  std::uint64_t infinite() const { return infinite_; }
  /// NaN without finite sizes. Of equal ones the first number has the place.
  double smallest() const;
  double largest() const;
  std::size_t smallest_at() const { return smallest_.at; }
  std::size_t largest_at() const { return largest_.at; }

 private:
  struct Place {
    std::int64_t bits;
    std::size_t at = 0;
  };
  struct Run {
    std::uint64_t bin = 0, length = 0;
  };

  bool keeps_all() const { return upper_.empty(); }
  void add_extremes(const std::vector<double>& numbers, std::size_t first);
  void take_extremes(const Place& smallest, const Place& largest);
  void count_run(Run& upper, const Run& fine);

  std::uint64_t count_ = 0, infinite_ = 0;
  Place smallest_{0x7ff0000000000000}, largest_{-1};  // above and below all finite ones
  std::vector<double> finite_;
  std::uint64_t fine_first_ = 0, below_ = 0;  // the first fine bin, and how many sizes are below it
  std::vector<std::uint64_t> upper_, fine_;
};

}  // namespace surveymc::stats
