#pragma once
/// Frames M = [n e d] (make_model.h) and the attitudes that they are. Azimuths are magnetic.
#include <Eigen/Core>

#include "survey/frames.h"

namespace surveymc::chained {

/// M of an attitude: n, e, d in the tool frame.
Eigen::Matrix3d frame_of(const survey::Attitude& attitude);

/// Attitude of a frame, toolface from y; in a vertical hole as attitude_from_fields().
survey::Attitude attitude_of(const Eigen::Matrix3d& frame);

/// Rows: derivatives of inclination, azimuth, toolface by the rotation delta (rad, tool axes). Those of azimuth and
/// toolface are infinite in a vertical hole, where only their sum exists.
Eigen::Matrix3d attitude_derivatives(const Eigen::Matrix3d& frame);

/// Standard deviations (rad) of inclination, azimuth, toolface from the covariance of delta. NaN for azimuth and
/// toolface within 1e-6 rad of the vertical.
Eigen::Vector3d attitude_sd(const Eigen::Matrix3d& frame, const Eigen::Matrix3d& covariance);

/// delta with `to` = exp([delta]x) `from`, rad.
Eigen::Vector3d rotation_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to);

}  // namespace surveymc::chained
