#pragma once
/// Quantiles of a sample, and an interval of the median that assumes nothing about the distribution.
#include <vector>

#include "stats/intervals.h"

namespace surveymc::stats {

/// Quantile of sorted values (at least one): the smallest with at least that share, in (0, 1], at or below it.
double sorted_quantile(const std::vector<double>& sorted, double share);

/// The middle value, or the mean of the two middle values of an even number; NaN without values. Values may be
/// infinite.
double median(std::vector<double> values);

/// Order statistics that hold the median with at least this confidence, whatever the distribution:
/// P(B <= l - 1) <= (1 - confidence) / 2 for B binomial(n, 1/2). With too few values: [0, infinity], the range of
/// delays.
Interval median_interval(const std::vector<double>& sorted, double confidence);

}  // namespace surveymc::stats
