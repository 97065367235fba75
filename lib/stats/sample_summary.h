#pragma once
/// Summary of one quantity for intervals and verdicts; its trials are independent or antithetic pairs.
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

/// Summary of component i of independent trials.
inline SampleSummary summarise(const Moments& trials, Eigen::Index i) {
  const double variance = trials.variance(i), kurtosis = trials.kurtosis(i);
  return {trials.count, trials.mean[i], variance, variance, kurtosis, trials.skewness(i), kurtosis};
}

/// Intervals of the mean and of the standard deviation (intervals.h).
inline Interval mean_interval(const SampleSummary& s, double confidence) {
  return mean_interval(s.mean, s.unit_variance, s.units, confidence);
}
inline Interval sd_interval(const SampleSummary& s, double confidence) {
  return sd_interval(s.variance, s.units, s.unit_kurtosis, confidence);
}

}  // namespace surveymc::stats
