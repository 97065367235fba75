#pragma once
#include <Eigen/Core>

namespace surveymc::propagate {

/// One-sigma ellipse of a 2x2 covariance (north, east): the eigenvectors are its axes. All NaN where the covariance is
/// not finite.
struct Ellipse {
  double semi_major = 0, semi_minor = 0;  ///< standard deviations along the axes, metres; 0 for a singular covariance
  double azimuth = 0;                     ///< of the major axis, rad clockwise from north, in [0, pi); 0 for a circle
  Eigen::Matrix2d axes;                   ///< columns: unit vectors (north, east) of the major and the minor axis
};
Ellipse ellipse(const Eigen::Matrix2d& covariance);

/// One-sigma ellipsoid of a 3x3 covariance (N, E, V). All NaN where the covariance is not finite.
struct Ellipsoid {
  Eigen::Vector3d semi_axes;  ///< standard deviations along the axes, metres, largest first; 0 where singular
  Eigen::Matrix3d axes;       ///< columns: their unit vectors, V >= 0 (pointing down)
};
Ellipsoid ellipsoid(const Eigen::Matrix3d& covariance);

/// Probability that a point of a 2-D normal distribution lies inside its k-sigma ellipse: 1 - exp(-k^2 / 2).
double ellipse_coverage(double k);

}  // namespace surveymc::propagate
