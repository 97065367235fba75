#pragma once
/// What is said of the probability that two wells touch, from one pair of points: r the vector between them (m), C its
/// covariance (m2), R the radii of both holes (m); u = r / |r|, D = |r|, sd = sqrt(u' C u).
#include <Eigen/Core>

namespace surveymc::proximity {

/// Phi(-(D - R) / sd): the one-dimensional hypothesis test. What has passed through counts, too.
double touch_half_space(const Eigen::Vector3d& r, const Eigen::Matrix3d& c, double radii);
/// Phi((-D + R) / sd) - Phi((-D - R) / sd): straight wells that cross, displaced as they are.
double touch_slab(const Eigen::Vector3d& r, const Eigen::Matrix3d& c, double radii);
/// The normal distribution over the disc of radius R in the plane across `along` (a unit vector): parallel wells,
/// displaced as they are (Foster 1992; Alfano 2005). NaN where C has no spread in that plane.
double touch_disc(const Eigen::Vector3d& r, const Eigen::Matrix3d& c, double radii, const Eigen::Vector3d& along);
/// The normal distribution over the ball of radius R: that the two points touch. NaN where C is singular.
double touch_point(const Eigen::Vector3d& r, const Eigen::Matrix3d& c, double radii);
/// P(chi2(3) > M^2) at the Mahalanobis distance M: the three-dimensional hypothesis test.
double touch_chi_squared(double mahalanobis);

}  // namespace surveymc::proximity
