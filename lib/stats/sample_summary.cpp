#include "stats/sample_summary.h"

namespace surveymc::stats {

SampleSummary summarise(const Moments& m, Eigen::Index i) {
  return {m.count, m.mean[i], m.variance(i), m.variance(i), m.kurtosis(i), m.skewness(i), m.kurtosis(i)};
}

Interval mean_interval(const SampleSummary& s, double confidence) {
  return mean_interval(s.mean, s.unit_variance, s.units, confidence);
}

Interval sd_interval(const SampleSummary& s, double confidence) {
  return sd_interval(s.variance, s.units, s.unit_kurtosis, confidence);
}

}  // namespace surveymc::stats
