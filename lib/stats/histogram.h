#pragma once
/// Quantiles of many values without keeping them: counts in equal bins.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "stats/intervals.h"

namespace surveymc::stats {

/// Bins [i width, (i + 1) width), i = 0 .. bins - 1; what lies beyond counts in the nearest bin. The counts themselves
/// are in a tally, where they merge.
struct HistogramBins {
  std::size_t bins = 4096;
  double width = 1;

  std::size_t bin(double value) const;
};

/// Value below which the share `probability` of the counts lies, linear within a bin; NaN without counts. Right to one
/// bin's width.
double histogram_quantile(const HistogramBins& bins, const std::uint64_t* counts, double probability);

/// Its confidence interval from the order statistics whose numbers are binomial quantiles (normal approximation).
Interval histogram_quantile_interval(const HistogramBins& bins, const std::uint64_t* counts, double probability,
                                     double confidence);

}  // namespace surveymc::stats
