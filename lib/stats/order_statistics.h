#pragma once
/// Quantiles of a sample, and what is known of the median of its distribution without assuming anything of it.
#include <vector>

#include "stats/intervals.h"

namespace surveymc::stats {

/// Quantile of sorted values (at least one): the smallest with at least that share, in (0, 1], at or below it.
double sorted_quantile(const std::vector<double>& sorted, double share);

/// Middle one of the values, the mean of the two middle ones of an even number; NaN of none. Values may be infinite.
double median(std::vector<double> values);

/// Order statistics that hold the median with at least this confidence, whatever the distribution:
/// P(B <= l - 1) <= (1 - confidence) / 2 for B binomial(n, 1/2). With few values: [0, infinity], for delays.
Interval median_interval(const std::vector<double>& sorted, double confidence);

}  // namespace surveymc::stats
