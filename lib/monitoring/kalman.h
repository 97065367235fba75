#pragma once
/// Kalman filter that follows the drift of sensors as a random walk.
#include <cmath>
#include <compare>

#include <Eigen/Core>

namespace surveymc::monitoring {

/// Variances of one sensor, in the units of z squared; sensors are independent and alike.
struct DriftFilterOptions {
  double process_variance = 1e-4;     ///< V: of the drift's step from sample to sample
  double measurement_variance = 0.3;  ///< Q: of reading less prediction
  double initial_variance = 0;        ///< M before the first sample
  double gate = 0;                    ///< a sample with |z - d| > gate sqrt(Q) in any sensor is skipped; 0: none is
  auto operator<=>(const DriftFilterOptions&) const = default;
};

/// Boechat, Moreno and Haramura, steps 1-5 of section 2.2:
///   M' = M + V,  K = M' / (Q + M'),  d += K (z - d),  M = (1 - K) M'
class DriftFilter {
 public:
  DriftFilter(const DriftFilterOptions& options, Eigen::Index sensors)
      : options_(options), variance_(options.initial_variance), drift_(Eigen::RowVectorXd::Zero(sensors)) {}

  /// z: observed drifts, reading less prediction. False if the gate skipped them: the variance grows, the drift stays.
  bool update(const Eigen::RowVectorXd& z) {
    const double predicted = variance_ + options_.process_variance;
    const double limit = options_.gate * std::sqrt(options_.measurement_variance);
    if (options_.gate > 0 && !((z - drift_).array().abs() <= limit).all()) {  // so that NaN is skipped, too
      variance_ = predicted;
      return false;
    }
    gain_ = predicted / (options_.measurement_variance + predicted);
    drift_ += gain_ * (z - drift_);
    variance_ = (1 - gain_) * predicted;
    return true;
  }

  const Eigen::RowVectorXd& drift() const { return drift_; }
  double variance() const { return variance_; }  ///< M, after the last sample
  double gain() const { return gain_; }          ///< K of the last sample that was used

 private:
  DriftFilterOptions options_;
  double variance_, gain_ = 0;
  Eigen::RowVectorXd drift_;
};

/// Limits of the variance before a sample (M') and of the gain after many samples.
struct SteadyDriftFilter {
  double predicted_variance, gain;
};
/// M'^2 - V M' - V Q = 0.
inline SteadyDriftFilter steady_drift_filter(const DriftFilterOptions& o) {
  const double v = o.process_variance, q = o.measurement_variance;
  const double predicted = (v + std::sqrt(v * v + 4 * v * q)) / 2;
  return {predicted, predicted / (q + predicted)};
}

}  // namespace surveymc::monitoring
