#pragma once
/// What intervals and verdicts need to know of one quantity, however its trials were drawn.
#include <cstdint>

#include <Eigen/Core>

#include "stats/intervals.h"
#include "stats/moments.h"

namespace surveymc::stats {

/// A quantity sampled in `units` independent units: trials, or antithetic pairs of them (antithetic.h).
struct SampleSummary {
  std::uint64_t units = 0;
  double mean = 0, variance = 0;      ///< of the quantity, unbiased
  double unit_variance = 0;           ///< of a unit's mean: `variance` where the units are trials
  double unit_kurtosis = 0;           ///< 1 + units var(variance) / variance^2: `kurtosis` where the units are trials
  double skewness = 0, kurtosis = 0;  ///< of the quantity
};

/// Of component i of independent trials.
SampleSummary summarise(const Moments& trials, Eigen::Index i);

/// Intervals of the mean and of the standard deviation (intervals.h).
Interval mean_interval(const SampleSummary& s, double confidence);
Interval sd_interval(const SampleSummary& s, double confidence);

}  // namespace surveymc::stats
