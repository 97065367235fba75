#pragma once
/// The interval of a mean of few, skewed values.
#include <vector>

#include "stats/intervals.h"

namespace surveymc::stats {

/// Mean of at least two values that are few and may be skewed, such as mean squared errors, one a realisation: each end
/// is the farther one of Student's interval and of the bootstrap-t's (Efron and Tibshirani 1993, section 12.5), which
/// takes the quantiles of (mean* - mean) / error* over 1999 resamples in the place of Student's. Never narrower than
/// Student's; the resamples are always the same. Fewer than 5 values, of which many resamples are all alike, and more
/// than 400 have Student's.
///   Where the long tail is one value in ten, no interval of a dozen values is right: that of the tests' lognormal
/// values holds 0.91 of the truth at 95 %, where Student's holds 0.85.
Interval skewed_mean_interval(const std::vector<double>& values, double confidence);

}  // namespace surveymc::stats
