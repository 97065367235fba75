#include "stats/histogram.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/units.h"

namespace surveymc::stats {

std::size_t HistogramBins::bin(double value) const {
  if (!(value > 0)) return 0;
  return std::min(bins - 1, static_cast<std::size_t>(std::min(value / width, 1e9)));
}

namespace {

/// The value below which so many of the values lie.
double value_at_rank(const HistogramBins& b, const std::uint64_t* counts, double wanted) {
  double below = 0;
  for (std::size_t i = 0; i < b.bins; ++i) {
    const auto here = static_cast<double>(counts[i]);
    if (here > 0 && below + here >= wanted) return b.width * (static_cast<double>(i) + (wanted - below) / here);
    below += here;
  }
  return b.width * static_cast<double>(b.bins);
}

/// The first of the whole numbers from `first` to `last` that is_so holds of, as it does of all that follow; `last`
/// where it holds of none before.
template <class IsSo>
std::uint64_t first_number(std::uint64_t first, std::uint64_t last, IsSo is_so) {
  while (first < last) {
    const std::uint64_t middle = first + (last - first) / 2;
    if (is_so(middle))
      last = middle;
    else
      first = middle + 1;
  }
  return first;
}

}  // namespace

std::uint64_t histogram_total(const HistogramBins& b, const std::uint64_t* counts) {
  return std::accumulate(counts, counts + b.bins, std::uint64_t{0});
}

double histogram_quantile(const HistogramBins& b, const std::uint64_t* counts, double probability) {
  const auto total = static_cast<double>(histogram_total(b, counts));
  return total == 0 ? kNaN : value_at_rank(b, counts, std::clamp(probability, 0.0, 1.0) * total);
}

std::uint64_t histogram_count(const HistogramBins& b, const std::uint64_t* counts, double value) {
  const double place = value / b.width;
  if (!(place > 0)) return 0;
  if (!(place < static_cast<double>(b.bins))) return histogram_total(b, counts);
  const auto bin = static_cast<std::size_t>(place);
  const double part = (place - static_cast<double>(bin)) * static_cast<double>(counts[bin]);
  return std::accumulate(counts, counts + bin, std::uint64_t{0}) + static_cast<std::uint64_t>(part);
}

Interval histogram_quantile_interval(const HistogramBins& b, const std::uint64_t* counts, double probability,
                                     double confidence) {
  const std::uint64_t total = histogram_total(b, counts);
  if (total == 0) return {kNaN, kNaN};
  const double tail = (1 - confidence) / 2;
  // l is the first k with P(B <= k) above the tail, as numbers of order statistics begin at 1.
  const std::uint64_t l =
      first_number(0, total, [&](std::uint64_t k) { return binomial_tails(k, total, probability).at_most > tail; });
  const std::uint64_t u = first_number(
      1, total + 1, [&](std::uint64_t k) { return binomial_tails(k, total, probability).at_least <= tail; });
  const auto at = [&](std::uint64_t rank) { return value_at_rank(b, counts, static_cast<double>(rank)); };
  return {l > 0 ? at(l) : 0, u <= total ? at(u) : kInfinity};
}

}  // namespace surveymc::stats
