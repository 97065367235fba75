#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "proximity/separation.h"
#include "stats/linear_algebra.h"

using namespace surveymc;
using namespace surveymc::proximity;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Sizes from 1e-3 to 1e3 m along random axes.
Matrix3d random_covariance(std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> power(-3, 3);
  Matrix3d a;
  for (int i = 0; i < 9; ++i) a(i) = normal(random);
  const Matrix3d axes = stats::orthonormal_columns(a);
  const Vector3d sd(std::pow(10, power(random)), std::pow(10, power(random)), std::pow(10, power(random)));
  return axes * sd.cwiseAbs2().asDiagonal() * axes.transpose();
}
Vector3d random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

/// F by a search over l in steps of 1e-4, with a general inverse.
double factor_by_search(const Vector3d& d, const Matrix3d& a, const Matrix3d& b) {
  double most = 0;
  for (int i = 1; i < 10000; ++i) {
    const double l = 1e-4 * i;
    most = std::max(most, l * (1 - l) * d.dot(Matrix3d((1 - l) * a + l * b).fullPivLu().solve(d)));
  }
  return std::sqrt(most);
}

}  // namespace

TEST_CASE("The separation factor of two vertical wells 100 m apart, as the clearance set prints it") {
  // ISCWSA standard set for clearance scenarios r4, offset 1, md 0 and 1 m: radii 0.7619628162 m, pedal 0.0017 m each.
  const SeparationRule rule;
  CHECK(separation_factor(rule, 100, 0.7619628162, 0) == Approx(56.53602125).epsilon(1e-10));
  CHECK(separation_factor(rule, 100, 0.7619628162, std::hypot(0.0017, 0.0017)) == Approx(56.5353677).epsilon(1e-8));
  CHECK(ellipse_separation(rule, 100, 0.762, 0) == Approx(99.238).epsilon(1e-12));
  // Holes that touch, and no uncertainty at all.
  CHECK(separation_factor(rule, 0, 0.762, 0) == Approx(-1.062 / 1.75).epsilon(1e-12));
  CHECK(separation_factor({3.5, 0, 0}, 2, 1, 0) == kInfinity);
  CHECK(separation_factor({3.5, 0, 0}, 1, 2, 0) == -kInfinity);
  CHECK(separation_factor({3.5, 0, 0}, 1, 1, 0) == 0);
}

TEST_CASE("The pedal radius is the sd of the distance, and never less cautious than the Mahalanobis distance") {
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    const Matrix3d c = random_covariance(random);
    const Vector3d d = random_vector(random), u = d.normalized();
    const double sigma_distance = d.norm() / pedal_radius(c, u), m = mahalanobis(d, c);
    CHECK(sigma_distance <= m * (1 + 1e-12));
    // Eigenvalues of condition 1e12 are known to 1e-4 of the smallest.
    CHECK(m == Approx(std::sqrt(d.dot(c.fullPivLu().solve(d)))).epsilon(1e-3));
    // The semi-axis in that direction is another thing, and never larger than the pedal radius.
    CHECK(1 / std::sqrt(u.dot(c.fullPivLu().solve(u))) <= pedal_radius(c, u) * (1 + 1e-3));
  }
  const Vector3d axis(0, 3, 0);
  CHECK(mahalanobis(axis, Vector3d(1, 4, 9).asDiagonal()) == Approx(1.5).epsilon(1e-14));
  CHECK(pedal_radius(Vector3d(1, 4, 9).asDiagonal(), axis.normalized()) == 2);
}

TEST_CASE("The ellipsoid factor is the largest of a dense search, between M / sqrt 2 and M", "[long]") {
  std::mt19937 random(5);
  for (int i = 0; i < 60; ++i) {
    // Moderate sizes, so that the maximum is not narrower than the search.
    const Matrix3d a = random_covariance(random) + 10 * Matrix3d::Identity(),
                   b = random_covariance(random) + 10 * Matrix3d::Identity();
    const Vector3d d = 100 * random_vector(random);
    const double f = ellipsoid_factor(d, a, b), m = mahalanobis(d, a + b), found = factor_by_search(d, a, b);
    CAPTURE(i, f, found);
    CHECK(f >= found * (1 - 1e-9));
    CHECK(f == Approx(found).epsilon(1e-5));
    CHECK(f <= m * (1 + 1e-9));
    CHECK(f >= m / std::sqrt(2) * (1 - 1e-9));
  }
  // Equal ellipsoids touch half way: F = D / (2 sd), M = D / (sqrt 2 sd). A point and an ellipsoid: F = M.
  const Matrix3d c = Vector3d(4, 9, 16).asDiagonal();
  CHECK(ellipsoid_factor({0, 12, 0}, c, c) == Approx(2).epsilon(1e-12));
  CHECK(ellipsoid_factor({0, 12, 0}, c, Matrix3d::Zero()) == Approx(4).epsilon(1e-9));
  CHECK(ellipsoid_factor({0, 12, 0}, Matrix3d::Zero(), c) == Approx(4).epsilon(1e-9));
  // Two spheres of sds 1 and 3 touch at k with k (1 + 3) = D.
  CHECK(ellipsoid_factor({10, 0, 0}, Matrix3d::Identity(), 9 * Matrix3d::Identity()) == Approx(2.5).epsilon(1e-12));
}

TEST_CASE("Singular covariances have their inverse within their range, and no point beyond it") {
  const Matrix3d depth_alone = Vector3d(0, 0, 0.1225).asDiagonal();  // a vertical tie-on
  CHECK(mahalanobis({0, 0, 7}, depth_alone) == Approx(20).epsilon(1e-14));
  CHECK(mahalanobis({100, 0, 7}, depth_alone) == kInfinity);
  CHECK(mahalanobis({0, 0, 0}, Matrix3d::Zero()) == 0);
  CHECK(mahalanobis({0, 0, 1}, Matrix3d::Zero()) == kInfinity);
  CHECK(ellipsoid_factor({0, 0, 7}, depth_alone, depth_alone) == Approx(10).epsilon(1e-12));
  CHECK(ellipsoid_factor({1, 0, 0}, depth_alone, depth_alone) == kInfinity);
  // Two that are singular each, but not together: l (1 - l) (9 / (1 - l) + 4 / l) = 9 l + 4 (1 - l) is most at an end.
  const Matrix3d flat = Vector3d(1, 1, 0).asDiagonal();
  CHECK(ellipsoid_factor({3, 0, 0.7}, flat, depth_alone) == Approx(3).epsilon(1e-9));
  CHECK(std::isnan(mahalanobis({1, 0, 0}, kNaN * flat)));
  CHECK(std::isnan(pedal_radius(kNaN * flat, {1, 0, 0})));
  // A plane that is turned: rounding must not make it regular.
  const Vector3d n = Vector3d(1, 2, 3).normalized();
  const Matrix3d plane = 100 * (Matrix3d::Identity() - n * n.transpose());
  const Vector3d within = n.cross(Vector3d(0, 1, 0));
  CHECK(mahalanobis(within, plane) == Approx(within.norm() / 10).epsilon(1e-12));
  CHECK(mahalanobis(within + 0.01 * n, plane) == kInfinity);
}
