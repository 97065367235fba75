#pragma once
/// From sensor errors to the covariance of a position, to first order.
///
/// With t_k the direction of the hole at station k and r the final position,
///   dr = sum_k dr/dt_k (dt_k/db db_k + dt_k/du du_k),
/// b the corrected field and u the down direction in the tool frame. dr/dt_k comes from minimum curvature. The azimuth
/// weighting functions dA/db of the literature are the horizontal part of dt/db; no angle appears here, so vertical
/// holes need no special case.
#include <array>
#include <vector>

#include <Eigen/Core>

#include "survey/frames.h"

namespace surveymc::propagate {

/// Effect of one station on the final position (N, E, V in metres, true north).
struct StationEffect {
  Eigen::Matrix3d by_field;  ///< per nT of the corrected field, tool axes
  Eigen::Matrix3d by_down;   ///< per unit of the down direction, tool axes, perpendicular to it
};

/// Derivatives of tangent_from_fields: how the direction of the hole (magnetic north) follows field and gravity.
struct TangentDerivatives {
  Eigen::Matrix3d by_field, by_down;
};
TangentDerivatives tangent_derivatives(const survey::StationFields& station);

/// One effect per station. `declination` in rad, `md` in metres.
std::vector<StationEffect> final_position_effects(const std::vector<double>& md,
                                                  const std::vector<survey::StationFields>& stations,
                                                  double declination);

/// Columns: six sensor errors of one station's magnetometers in the order gain x, y, z (1), bias x, y, z (nT), after
/// a correction with `gain`: the corrected field changes by -b_i / gain_i and -1 / gain_i per axis.
using Matrix36d = Eigen::Matrix<double, 3, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
Matrix36d magnetometer_error_effect(const StationEffect& effect, const survey::StationFields& station,
                                    const std::array<double, 3>& gain);

/// Propagation of an error from station to station (thesis eqs 41-47 for one survey leg).
/// `effects` holds one 3x6 matrix per station.
///   systematic  constant in the run, the six errors independent:      sum_i sd_i^2 (sum x_i)(sum x_i)'
///   random      independent from station to station and of another:   sum_i sd_i^2 sum x_i x_i'
Eigen::Matrix3d propagate_systematic(const std::vector<Matrix36d>& effects, const Vector6d& sd);
Eigen::Matrix3d propagate_random(const std::vector<Matrix36d>& effects, const Vector6d& sd);

}  // namespace surveymc::propagate
