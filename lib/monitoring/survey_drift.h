#pragma once
/// Drift of a survey tool's own sensors, seen against the reference field: no empirical model is needed, because |g|,
/// |b| and dip of the reference already are the prediction.
#include <Eigen/Core>

namespace surveymc::monitoring {

using Vector6 = Eigen::Matrix<double, 6, 1>;  ///< accelerometers x, y, z, magnetometers x, y, z
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using ChannelJacobian = Eigen::Matrix<double, 3, 6>;

/// |g|, |b| and dip (rad, positive down) of a station: asin(g.b / (|g| |b|)), g pointing down. Any units.
Eigen::Vector3d survey_channels(const Eigen::Vector3d& g, const Eigen::Vector3d& b);

/// Derivatives of these channels by the six readings. b must not be parallel to g.
ChannelJacobian survey_channel_jacobian(const Eigen::Vector3d& g, const Eigen::Vector3d& b);

/// Kalman filter on six biases as random walks. Station by station, with H the Jacobian of the channels:
///   P' = P + Q,  K = P' H^T (H P' H^T + R)^-1,  d += K (y - H d),  P = (1 - K H) P' (1 - K H)^T + K R K^T
/// y: channels less reference; R: covariance of y without drift.
class BiasFilter {
 public:
  explicit BiasFilter(const Vector6& process_variance)
      : process_(process_variance), bias_(Vector6::Zero()), covariance_(Matrix6::Zero()) {}

  /// Returns the normalised innovation squared (NIS), v^T (H P' H^T + R)^-1 v with v = y - H d of before: chi-squared
  /// with 3 degrees of freedom if the sensors are as the filter takes them to be.
  double update(const Eigen::Vector3d& y, const ChannelJacobian& h, const Eigen::Matrix3d& r);
  const Vector6& bias() const { return bias_; }
  const Matrix6& covariance() const { return covariance_; }

 private:
  Vector6 process_, bias_;
  Matrix6 covariance_;
};

/// Normalised estimation error squared (NEES), e^T P^-1 e: chi-squared with 6 degrees of freedom if the error e of the
/// six biases has the covariance P.
double normalised_error(const Vector6& error, const Matrix6& covariance);

}  // namespace surveymc::monitoring
