#include "monitoring/kalman.h"

namespace surveymc::monitoring {

SteadyDriftFilter steady_drift_filter(const DriftFilterOptions& o) {
  const double v = o.process_variance, q = o.measurement_variance;
  const double predicted = (v + std::sqrt(v * v + 4 * v * q)) / 2;
  return {predicted, predicted / (q + predicted)};
}

}  // namespace surveymc::monitoring
