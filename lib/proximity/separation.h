#pragma once
/// How far two wells are apart in units of their uncertainty: the separation rule of SPE 187073, and distances in
/// standard deviations.
///
/// d is the vector from the one point to the other (m), D = |d|, u = d / D, C a covariance (m2).
#include <Eigen/Core>

namespace surveymc::proximity {

/// The rule's constants and the sum of the radii of both holes (m).
struct SeparationRule {
  double scale_factor = 3.5;    ///< k
  double surface_margin = 0.3;  ///< S_m, m
  double project_ahead = 0.5;   ///< sigma_pa, m
};

/// Pedal radius sqrt(u' C u): the standard deviation of the distance. Not the semi-axis 1 / sqrt(u' C^-1 u). 0 for u =
/// 0.
double pedal_radius(const Eigen::Matrix3d& c, const Eigen::Vector3d& u);

/// SF = (D - R_ref - R_off - S_m) / (k sqrt(sd^2 + sigma_pa^2)); negative where the holes touch. `radii` = R_ref +
/// R_off. Without any uncertainty (sd = sigma_pa = 0) it is infinite, with the sign of the numerator.
double separation_factor(const SeparationRule& rule, double distance, double radii, double sd_relative);
/// ES = D - R_ref - R_off - k sd: without S_m and sigma_pa. m
double ellipse_separation(const SeparationRule& rule, double distance, double radii, double sd_relative);

/// M = sqrt(d' C^-1 d). Of a singular C the inverse in its range; infinite where d leaves the range, 0 for d = 0.
/// D / pedal radius <= M always (Cauchy and Schwarz): the pedal radius is never less cautious.
double mahalanobis(const Eigen::Vector3d& d, const Eigen::Matrix3d& c);

/// F: the k at which the k-sigma ellipsoids of two points with independent errors touch,
///   F^2 = max over l in (0, 1) of l (1 - l) d' [(1 - l) C_a + l C_b]^-1 d.
/// The function of l is concave; M / sqrt(2) <= F <= M with M of C_a + C_b. Singular matrices as in mahalanobis().
double ellipsoid_factor(const Eigen::Vector3d& d, const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

}  // namespace surveymc::proximity
