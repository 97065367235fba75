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

double histogram_quantile(const HistogramBins& b, const std::uint64_t* counts, double probability) {
  const auto total = static_cast<double>(std::accumulate(counts, counts + b.bins, std::uint64_t{0}));
  if (total == 0) return kNaN;
  const double wanted = std::clamp(probability, 0.0, 1.0) * total;
  double below = 0;
  for (std::size_t i = 0; i < b.bins; ++i) {
    const auto here = static_cast<double>(counts[i]);
    if (here > 0 && below + here >= wanted) return b.width * (static_cast<double>(i) + (wanted - below) / here);
    below += here;
  }
  return b.width * static_cast<double>(b.bins);
}

Interval histogram_quantile_interval(const HistogramBins& b, const std::uint64_t* counts, double probability,
                                     double confidence) {
  const auto total = static_cast<double>(std::accumulate(counts, counts + b.bins, std::uint64_t{0}));
  const double half =
      normal_quantile(1 - (1 - confidence) / 2) * std::sqrt(probability * (1 - probability) / std::max(total, 1.0));
  return {histogram_quantile(b, counts, probability - half), histogram_quantile(b, counts, probability + half)};
}

}  // namespace surveymc::stats
