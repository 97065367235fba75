#pragma once
/// A mixture of normals in space: the distribution of a position's error where it is no normal one.
#include <vector>

#include <Eigen/Core>

#include "orders/chain.h"

namespace surveymc::orders {

struct MixturePart {
  double weight = 0;                                     ///< all add up to 1
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();        ///< N, E, V, m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m2
};
using Mixture = std::vector<MixturePart>;

Moments moments_of(const Mixture& mixture);

/// Of the component along a direction: mean and sd in m, skewness, kurtosis (3 of a normal one; NaN without spread).
struct Shape {
  double mean = 0, sd = 0, skewness = 0, kurtosis = 0;
};
Shape shape_along(const Mixture& mixture, const Eigen::Vector3d& direction);

/// The x with P(component <= x) = p, p in (0, 1).
double quantile(const Mixture& mixture, const Eigen::Vector3d& direction, double p);

/// Probability density of the component, 1/m, without parts that have no spread (without_gaps() in profile.h has none).
double density(const Mixture& mixture, const Eigen::Vector3d& direction, double x);

/// Probability of (x - centre)' C^-1 (x - centre) <= k^2 of the horizontal parts of x, centre and C, for every k: what
/// the ellipse of k sigma holds. By quadrature, right to 1e-6 a part; the parts of a profile of 241 points without
/// spread along it leave 2e-3 of the 1 sigma ellipse and less of larger ones. NaN where the ellipse has no area.
std::vector<double> inside_ellipse(const Mixture& mixture, const Eigen::Vector3d& centre, const Eigen::Matrix3d& c,
                                   const std::vector<double>& k);

}  // namespace surveymc::orders
