#include "stats/size_counts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <span>
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

SizeCounts::SizeCounts(std::uint64_t first_bin, int bin_bits)
    : bins_(kBins),
      first_bin_(first_bin),
      bin_bits_(bin_bits),
      begin_(static_cast<std::int64_t>(first_bin << bin_bits)),
      end_(first_bin + kBins <= static_cast<std::uint64_t>(kInfinite) >> bin_bits
               ? static_cast<std::int64_t>((first_bin + kBins) << bin_bits)
               : kInfinite) {}

SizeCounts SizeCounts::of_all() { return {0, 48}; }

SizeCounts SizeCounts::near(double expected) {
  constexpr int kBits = 32;
  return {std::max(static_cast<std::uint64_t>(bits_of(expected)) >> kBits, kBins / 2) - kBins / 2, kBits};
}

void SizeCounts::add(const std::vector<double>& numbers, std::size_t first) {
  // Without branches, so that compilers look at several numbers at once.
  std::int64_t smallest = kInfinite, largest = -1, finite = 0, infinite = 0;
  for (const double x : numbers) {
    const std::int64_t bits = bits_of(x);
    smallest = std::min(smallest, bits);
    largest = std::max(largest, bits < kInfinite ? bits : -1);
    finite += bits < kInfinite ? 1 : 0;
    infinite += bits == kInfinite ? 1 : 0;
  }
  constexpr std::size_t kFew = 16;
  for (std::size_t at = 0; at < numbers.size(); at += kFew) {
    const std::span<const double> few(numbers.data() + at, std::min(kFew, numbers.size() - at));
    std::int64_t below = 0, below_end = 0;
    for (const double x : few) {
      below += bits_of(x) < begin_ ? 1 : 0;
      below_end += bits_of(x) < end_ ? 1 : 0;
    }
    below_ += static_cast<std::uint64_t>(below);
    if (below_end == below) continue;
    for (const double x : few) {
      const std::int64_t bits = bits_of(x);
      if (bits >= begin_ && bits < end_) ++bins_[(static_cast<std::uint64_t>(bits) >> bin_bits_) - first_bin_];
    }
  }
  if (keeps_all())
    for (const double x : numbers)
      if (std::isfinite(x)) finite_.push_back(std::abs(x));
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

void SizeCounts::add(const SizeCounts& other) {
  take_extremes(other.smallest_, other.largest_);
  count_ += other.count_;
  infinite_ += other.infinite_;
  below_ += other.below_;
  for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i] += other.bins_[i];
  finite_.insert(finite_.end(), other.finite_.begin(), other.finite_.end());
}

bool SizeCounts::has_median() const {
  if (keeps_all() || count_ == 0) return true;
  const std::uint64_t in_bins = std::accumulate(bins_.begin(), bins_.end(), std::uint64_t{0});
  return count_ / 2 >= below_ && count_ / 2 < below_ + in_bins;
}

double SizeCounts::median() const {
  if (keeps_all()) return stats::median(finite_);
  if (count_ == 0) return kNaN;
  const std::uint64_t bin = first_bin_ + bin_of_rank(bins_, count_ / 2 - below_);
  return std::bit_cast<double>(bin << bin_bits_ | std::uint64_t{1} << (bin_bits_ - 1));
}

double SizeCounts::smallest() const { return count_ > 0 ? std::bit_cast<double>(smallest_.bits) : kNaN; }
double SizeCounts::largest() const { return count_ > 0 ? std::bit_cast<double>(largest_.bits) : kNaN; }

void SizeCounts::take_extremes(const Place& smallest, const Place& largest) {
  if (std::pair{smallest.bits, smallest.at} < std::pair{smallest_.bits, smallest_.at}) smallest_ = smallest;
  if (std::pair{-largest.bits, largest.at} < std::pair{-largest_.bits, largest_.at}) largest_ = largest;
}

}  // namespace surveymc::stats
