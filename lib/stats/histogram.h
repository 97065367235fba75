#pragma once
/// Quantiles of many values from counts in equal bins; the values are not kept.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "stats/intervals.h"

namespace surveymc::stats {

/// Bins [i width, (i + 1) width), i = 0 .. bins - 1; values beyond count in the nearest bin. The counts themselves are
/// in a tally, where they merge.
struct HistogramBins {
  std::size_t bins = 4096;
  double width = 1;

  std::size_t bin(double value) const;
};

/// Value below which the share `probability` of the counts lies, linear within a bin; NaN without counts.
/// Accurate to one bin's width.
double histogram_quantile(const HistogramBins& bins, const std::uint64_t* counts, double probability);

/// Number of values up to `value`, linear within a bin.
std::uint64_t histogram_count(const HistogramBins& bins, const std::uint64_t* counts, double value);

/// Number of values.
std::uint64_t histogram_total(const HistogramBins& bins, const std::uint64_t* counts);

/// Confidence interval of a quantile from order statistics, whatever the distribution: of n values, and B binomial(n,
/// probability), the largest x_(l) with P(B < l) <= (1 - confidence) / 2 and the smallest x_(u) with P(B >= u) at most
/// that. 0 and infinity where no x has it: the 95 % quantile has an upper bound at 95 % from n = 72 on.
Interval histogram_quantile_interval(const HistogramBins& bins, const std::uint64_t* counts, double probability,
                                     double confidence);

}  // namespace surveymc::stats
