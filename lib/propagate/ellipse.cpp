#include "propagate/ellipse.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/standard_deviation.h"
#include "base/units.h"
#include "stats/linear_algebra.h"

namespace surveymc::propagate {
namespace {

constexpr double kRounding = 1e-13;  // of a covariance's elements, relative to the largest
constexpr double kSingular = 1e-14;  // an eigenvalue below this part of the largest is rounding, too

constexpr double kLevel = 1e-9;  // how far the end of a unit axis may be from the horizontal by rounding

}  // namespace

Ellipse ellipse(const Eigen::Matrix2d& covariance) {
  Ellipse e;
  if (!covariance.allFinite()) {
    e.semi_major = e.semi_minor = e.azimuth = kNaN;
    e.axes.setConstant(kNaN);
    return e;
  }
  const stats::SmallSymmetricEigen<2> eigen = stats::symmetric_eigen(covariance);
  const double largest = std::max(0.0, eigen.values[1]), smallest = eigen.values[0];
  e.semi_major = std::sqrt(largest);
  e.semi_minor = smallest > kSingular * largest ? std::sqrt(smallest) : 0.0;
  if (largest - smallest <= kRounding * largest) {  // a circle: rounding must not choose an axis
    e.axes.setIdentity();
    return e;
  }
  e.axes.col(0) = eigen.vectors.col(1);
  e.axes.col(1) = eigen.vectors.col(0);
  e.azimuth = std::atan2(e.axes(1, 0), e.axes(0, 0));
  if (e.azimuth < 0) e.azimuth += kPi;
  if (e.azimuth >= kPi) e.azimuth -= kPi;
  return e;
}

Ellipsoid ellipsoid(const Eigen::Matrix3d& covariance) {
  Ellipsoid e;
  if (!covariance.allFinite()) {
    e.semi_axes.setConstant(kNaN);
    e.axes.setConstant(kNaN);
    return e;
  }
  const stats::SmallSymmetricEigen<3> eigen = stats::symmetric_eigen(covariance);
  if ((covariance - Eigen::Matrix3d(covariance.diagonal().asDiagonal())).cwiseAbs().maxCoeff() <=
      kRounding * covariance.diagonal().maxCoeff()) {
    // The axes are N, E, V (a vertical hole): of equal ones, rounding must not choose the order or turn them.
    std::array<int, 3> order{0, 1, 2};
    std::stable_sort(order.begin(), order.end(),
                     [&](int i, int j) { return covariance(i, i) - covariance(j, j) > kRounding * covariance(i, i); });
    for (int i = 0; i < 3; ++i) {
      const int axis = order[static_cast<std::size_t>(i)];
      e.semi_axes[i] = standard_deviation(covariance(axis, axis));
      e.axes.col(i) = Eigen::Vector3d::Unit(axis);
    }
    return e;
  }
  for (int i = 0; i < 3; ++i) {
    const double variance = eigen.values[2 - i];
    e.semi_axes[i] = variance > kSingular * eigen.values[2] ? std::sqrt(variance) : 0.0;
    e.axes.col(i) = eigen.vectors.col(2 - i);
    const Eigen::Vector3d axis = e.axes.col(i);
    // Downwards; a horizontal one towards 0 to 180 deg: rounding must not choose its end.
    const bool is_level = std::abs(axis.z()) <= kLevel;
    const bool is_west = axis.y() < -kLevel || (axis.y() <= kLevel && axis.x() < 0);
    if (is_level ? is_west : axis.z() < 0) e.axes.col(i) *= -1;
  }
  return e;
}

double ellipse_coverage(double k) { return -std::expm1(-k * k / 2); }

}  // namespace surveymc::propagate
