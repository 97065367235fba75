#include "proximity/touch_predictions.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <boost/math/quadrature/gauss.hpp>

#include "base/standard_deviation.h"
#include "base/units.h"
#include "rare/test_functions.h"
#include "stats/intervals.h"
#include "stats/linear_algebra.h"
#include "stats/normal_tail.h"

namespace surveymc::proximity {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kFlat = 1e-12;  // of the largest variance: no spread

double sd_along(const Vector3d& r, const Matrix3d& c) {
  const Vector3d u = r.normalized();
  return standard_deviation(u.dot(c * u));
}

}  // namespace

double touch_half_space(const Vector3d& r, const Matrix3d& c, double radii) {
  return stats::normal_upper_tail((r.norm() - radii) / sd_along(r, c));
}

double touch_slab(const Vector3d& r, const Matrix3d& c, double radii) {
  const double sd = sd_along(r, c), d = r.norm();
  return stats::normal_upper_tail((d - radii) / sd) - stats::normal_upper_tail((d + radii) / sd);
}

double touch_disc(const Vector3d& r, const Matrix3d& c, double radii, const Vector3d& along) {
  Eigen::Matrix<double, 3, 2> plane;
  plane.col(0) = along.unitOrthogonal();
  plane.col(1) = along.cross(plane.col(0));
  const auto eigen = stats::symmetric_eigen(Eigen::Matrix2d(plane.transpose() * c * plane));
  if (!(eigen.values[0] > kFlat * eigen.values[1])) return kNaN;
  const Eigen::Vector2d mean = eigen.vectors.transpose() * (plane.transpose() * r);
  rare::TestProblem disc;
  disc.name = "disc";
  disc.mean = {mean[1], mean[0]};  // along the larger axis first
  disc.sd = {std::sqrt(eigen.values[1]), std::sqrt(eigen.values[0])};
  disc.radius = radii;
  return rare::exact_probability(disc);
}

double touch_point(const Vector3d& r, const Matrix3d& c, double radii) {
  const auto eigen = stats::symmetric_eigen(c);
  const Vector3d w = eigen.values;
  if (!(w[0] > kFlat * w[2])) return kNaN;
  const Vector3d mean = eigen.vectors.transpose() * r, sd = w.cwiseSqrt();
  // Discs along the largest axis, at radius sin t.
  rare::TestProblem disc;
  disc.name = "disc";
  disc.mean = {mean[1], mean[0]};
  disc.sd = {sd[1], sd[0]};
  return boost::math::quadrature::gauss<double, 40>::integrate(
      [&](double t) {
        const double x = (radii * std::sin(t) - mean[2]) / sd[2];
        disc.radius = radii * std::cos(t);
        return std::exp(-x * x / 2) / std::sqrt(2 * kPi) / sd[2] * disc.radius * rare::exact_probability(disc);
      },
      -kPi / 2, kPi / 2);
}

double touch_chi_squared(double mahalanobis) { return stats::chi_squared_upper_tail(3, mahalanobis * mahalanobis); }

}  // namespace surveymc::proximity
