#pragma once
/// Extremes and median of the sizes |x| of many numbers, which come in pieces. Counts of disjoint pieces add up to the
/// same bits, whichever process has made them.
#include <cstddef>
#include <cstdint>
#include <vector>

namespace surveymc::stats {

/// Infinite numbers are counted apart, NaN not at all. Bins are of bit patterns, which have the order of the numbers.
class SizeCounts {
 public:
  /// Keeps all finite sizes: its median is exact, as of stats::median().
  SizeCounts() = default;
  /// In bins of a sixteenth: its median is the middle of the bin that has the size of rank n / 2.
  static SizeCounts of_all();
  /// Only those within some 2 percent of `expected`, in 65,536 bins: its median is the size of rank n / 2, to 1e-6 of
  /// itself, if that is among them. The median of of_all() is always near enough to be expected.
  static SizeCounts near(double expected);

  /// Numbers first, first + 1, ... of all.
  void add(const std::vector<double>& numbers, std::size_t first);
  /// `other`: of other numbers, made with the same arguments.
  void add(const SizeCounts& other);

  /// False: the median is not near what was expected.
  bool has_median() const;
  /// NaN if no size is finite.
  double median() const;

  std::uint64_t infinite() const { return infinite_; }
  /// NaN if no size is finite. Ties go to the lower number.
  double smallest() const;
  double largest() const;
  std::size_t smallest_at() const { return smallest_.at; }
  std::size_t largest_at() const { return largest_.at; }

 private:
  struct Place {
    std::int64_t bits;
    std::size_t at = 0;
  };
  SizeCounts(std::uint64_t first_bin, int bin_bits);

  bool keeps_all() const { return bins_.empty(); }
  void take_extremes(const Place& smallest, const Place& largest);

  std::uint64_t count_ = 0, infinite_ = 0;
  Place smallest_{0x7ff0000000000000}, largest_{-1};  // above and below all finite ones
  std::vector<double> finite_;
  std::uint64_t below_ = 0;  // how many sizes are below the bins
  std::vector<std::uint64_t> bins_;
  std::uint64_t first_bin_ = 0;  // the number of bins_[0]; a size has that of its bits without the lower bin_bits_
  int bin_bits_ = 0;
  std::int64_t begin_ = 0, end_ = 0;  // bits of the sizes that have bins
};

}  // namespace surveymc::stats
