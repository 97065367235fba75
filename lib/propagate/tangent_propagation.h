#pragma once
/// From errors of the hole's direction at each station to the covariance of every position, in one pass.
#include <vector>

#include <Eigen/Core>

#include "survey/position_method.h"

namespace surveymc::propagate {

/// How the direction of the hole at one station (N frame, true north) follows unit-variance errors, one a column.
struct TangentErrors {
  Eigen::Matrix3Xd constant;     ///< the same error at all stations; column i of every station is one error
  Eigen::Matrix3Xd independent;  ///< errors of this station alone
};

/// Covariance of the position (N, E, V, m2) at every station, to first order; zero at the first.
///   C_r = (sum_k D_rk X_k)(sum_k D_rk X_k)' + sum_k D_rk Y_k Y_k' D_rk',  D_rk = dr_r/dt_k,
/// X constant, Y independent. The station reached has only its interval before (ISCWSA's e*), the others both (e).
/// `md` in metres, `tangents` in N, one `errors` a station, all with as many constant columns. Linear time.
std::vector<Eigen::Matrix3d> propagate_tangent_errors(const std::vector<double>& md,
                                                      const std::vector<survey::Vec3<double>>& tangents,
                                                      const std::vector<TangentErrors>& errors,
                                                      survey::PositionMethod method);

}  // namespace surveymc::propagate
