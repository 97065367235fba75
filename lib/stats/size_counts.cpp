#include "stats/size_counts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/units.h"
#include "stats/order_statistics.h"

namespace surveymc::stats {
namespace {

constexpr std::uint64_t kBins = std::uint64_t{1} << 16;
constexpr std::int64_t kInfinite = std::bit_cast<std::int64_t>(kInfinity);

/// Bits of |x|: above kInfinite it is no number. Signed, because more instruction sets compare these side by side.
std::int64_t bits_of(double x) { return std::bit_cast<std::int64_t>(x) & ~(std::int64_t{1} << 63); }

/// The bin that holds the size of this rank, from 0.
std::uint64_t bin_of_rank(const std::vector<std::uint64_t>& counts, std::uint64_t rank) {
  std::uint64_t bin = 0;
  while (bin + 1 < counts.size() && rank >= counts[bin]) rank -= counts[bin++];
  return bin;
}

}  // namespace

SizeCounts::SizeCounts(double expected)
    : fine_first_(std::max(static_cast<std::uint64_t>(bits_of(expected)) >> 32, kBins / 2) - kBins / 2),
      upper_(kBins),
      fine_(kBins) {}

void SizeCounts::add(const std::vector<double>& numbers, std::size_t first) {
  add_extremes(numbers, first);
  if (keeps_all()) {
    for (const double x : numbers)
      if (std::isfinite(x)) finite_.push_back(std::abs(x));
    return;
  }
  // Neighbours are alike or the same: runs of one bin are counted at once.
  Run upper, fine;
  for (const double x : numbers) {
    const std::int64_t bits = bits_of(x);
    if (bits >= kInfinite) continue;
    const auto bin = static_cast<std::uint64_t>(bits) >> 32;
    if (bin == fine.bin) {
      ++fine.length;
      continue;
    }
    count_run(upper, fine);
    fine = {bin, 1};
  }
  count_run(upper, fine);
  upper_[upper.bin] += upper.length;
}

void SizeCounts::add(const SizeCounts& other) {
  take_extremes(other.smallest_, other.largest_);
  count_ += other.count_;
  infinite_ += other.infinite_;
  below_ += other.below_;
  for (std::size_t i = 0; i < upper_.size(); ++i) upper_[i] += other.upper_[i];
  for (std::size_t i = 0; i < fine_.size(); ++i) fine_[i] += other.fine_[i];
  finite_.insert(finite_.end(), other.finite_.begin(), other.finite_.end());
}

bool SizeCounts::has_median() const {
  if (keeps_all() || count_ == 0) return true;
  const std::uint64_t fine = std::accumulate(fine_.begin(), fine_.end(), std::uint64_t{0});
  return count_ / 2 >= below_ && count_ / 2 < below_ + fine;
}

double SizeCounts::expected_median() const {
  if (has_median()) return median();
  // The middle of its upper bin, all of which is then counted finely.
  return std::bit_cast<double>(bin_of_rank(upper_, count_ / 2) << 48 | std::uint64_t{1} << 47);
}

double SizeCounts::median() const {
  if (keeps_all()) return stats::median(finite_);
  if (count_ == 0) return kNaN;
  const std::uint64_t bin = fine_first_ + bin_of_rank(fine_, count_ / 2 - below_);
  return std::bit_cast<double>(bin << 32 | std::uint64_t{1} << 31);
}

double SizeCounts::smallest() const { return count_ > 0 ? std::bit_cast<double>(smallest_.bits) : kNaN; }
double SizeCounts::largest() const { return count_ > 0 ? std::bit_cast<double>(largest_.bits) : kNaN; }

void SizeCounts::add_extremes(const std::vector<double>& numbers, std::size_t first) {
  // Without branches, so that compilers look at several numbers at once.
  std::int64_t smallest = kInfinite, largest = -1, finite = 0, infinite = 0;
  for (const double x : numbers) {
    const std::int64_t bits = bits_of(x);
    smallest = std::min(smallest, bits);
    largest = std::max(largest, bits < kInfinite ? bits : -1);
    finite += bits < kInfinite ? 1 : 0;
    infinite += bits == kInfinite ? 1 : 0;
  }
  count_ += static_cast<std::uint64_t>(finite);
  infinite_ += static_cast<std::uint64_t>(infinite);
  if (finite == 0) return;
  const auto place_of = [&](std::int64_t bits) {
    const auto at = std::find_if(numbers.begin(), numbers.end(), [bits](double x) { return bits_of(x) == bits; });
    return Place{bits, first + static_cast<std::size_t>(at - numbers.begin())};
  };
  take_extremes(smallest <= smallest_.bits ? place_of(smallest) : smallest_,
                largest >= largest_.bits ? place_of(largest) : largest_);
}

void SizeCounts::take_extremes(const Place& smallest, const Place& largest) {
  if (std::pair{smallest.bits, smallest.at} < std::pair{smallest_.bits, smallest_.at}) smallest_ = smallest;
  if (std::pair{-largest.bits, largest.at} < std::pair{-largest_.bits, largest_.at}) largest_ = largest;
}

void SizeCounts::count_run(Run& upper, const Run& fine) {
  const std::uint64_t bin = fine.bin >> 16;
  if (bin != upper.bin) {
    upper_[upper.bin] += upper.length;
    upper = {bin, 0};
  }
  upper.length += fine.length;
  if (fine.bin - fine_first_ < kBins)
    fine_[fine.bin - fine_first_] += fine.length;
  else if (fine.bin < fine_first_)
    below_ += fine.length;
}

}  // namespace surveymc::stats
