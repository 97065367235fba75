#pragma once
/// Covariance of directions and positions along a whole well that was corrected with an estimate from its own readings.
///
/// Everything random is a draw of unit variance: six of each station (magnetometer x, y, z, accelerometer x, y, z), and
/// the reference's. A draw of station j moves the tangent t_j, and through the estimate x all tangents:
///   dt_k = T_k d_k + Y_k dx,  dx = sum_j S_j d_j + (what the reference gives)
/// so that, to first order and with the correlation of a station's noise and the estimate that it enters,
///   cov t_k = T_k T_k' + T_k S_k' Y_k' + Y_k S_k T_k' + Y_k C Y_k',  C = cov x.
/// Positions sum dr/dt_k dt_k. dr_k/dt_j is the same for all stations k beyond j + 1, so running sums give all stations
/// in a time linear in their number.
#include <vector>

#include <Eigen/Core>

#include "propagate/station_effects.h"

namespace surveymc::propagate {

/// Derivatives of one station by its own draws and by the estimate.
struct StationErrors {
  Eigen::Matrix<double, 3, 6> tangent_by_draws;       ///< T: of its own draws, the estimate being fixed
  Matrix6d parameters_by_draws;                       ///< S: of its own draws, on the estimate
  Eigen::Matrix<double, 3, 6> tangent_by_parameters;  ///< Y
};

/// Derivatives of the azimuth (rad) of one station by the corrected field (per nT) and by the down direction (per
/// unit, perpendicular to it). In a vertical hole the azimuth is that of azimuth + toolface by the field, and
/// infinitely sensitive to the down direction.
struct AzimuthDerivatives {
  Eigen::RowVector3d by_field, by_down;
};
AzimuthDerivatives azimuth_derivatives(const survey::StationFields& station);

/// Covariance of `own d + by_parameters dx` for one station: m quantities, `own` and `by_parameters` m x 6.
Eigen::MatrixXd covariance_with_estimate(const Eigen::MatrixXd& own, const Eigen::MatrixXd& by_parameters,
                                         const Matrix6d& parameters_by_draws, const Matrix6d& parameter_covariance);

/// Covariance of the position (N, E, V, m2) of every station relative to the first, where it is zero.
/// `tangents` in N, true north; minimum curvature.
std::vector<Eigen::Matrix3d> position_covariances(const std::vector<double>& md,
                                                  const std::vector<survey::Vec3<double>>& tangents,
                                                  const std::vector<StationErrors>& stations,
                                                  const Matrix6d& parameter_covariance);

}  // namespace surveymc::propagate
