// Predictions beyond first order (lib/orders) on chains whose moments are known in closed form.
#include <cmath>
#include <functional>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "orders/order_needed.h"
#include "orders/profile.h"
#include "orders/second.h"
#include "orders/sigma_points.h"
#include "stats/intervals.h"
#include "stats/normal_tail.h"

using namespace surveymc;
using namespace surveymc::orders;
using Catch::WithinAbs;
using Catch::WithinRel;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// F given as a function; its derivatives by differences.
class GivenChain final : public Chain {
 public:
  using Function = std::function<Vector3d(const VectorXd&)>;
  GivenChain(Eigen::Index dimension, Function f) : dimension_(dimension), f_(std::move(f)) {}
  Eigen::Index dimension() const override { return dimension_; }
  Eigen::Matrix3Xd values(const MatrixXd& z) const override {
    Eigen::Matrix3Xd out(3, z.cols());
    for (Eigen::Index i = 0; i < z.cols(); ++i) out.col(i) = f_(z.col(i));
    return out;
  }
  Path path(const VectorXd& v, const std::vector<double>& t) const override {
    MatrixXd z(dimension_, static_cast<Eigen::Index>(t.size()));
    for (std::size_t i = 0; i < t.size(); ++i) z.col(static_cast<Eigen::Index>(i)) = t[i] * v;
    return {values(z), {}};
  }
  Expansion expand(const VectorXd& z, const VectorXd&, const ExpansionParts& parts) const override {
    constexpr double kStep = 1e-3;
    const auto at = [&](Eigen::Index i, double a, Eigen::Index j, double b) {
      VectorXd x = z;
      x[i] += a * kStep;
      x[j] += b * kStep;
      return f_(x);
    };
    Expansion e;
    e.first.resize(3, dimension_);
    std::array<MatrixXd, 3> h;
    for (MatrixXd& m : h) m.resize(dimension_, dimension_);
    for (Eigen::Index i = 0; i < dimension_; ++i) {
      e.first.col(i) = (at(i, 1, i, 0) - at(i, -1, i, 0)) / (2 * kStep);
      for (Eigen::Index j = 0; j < dimension_; ++j) {
        const Vector3d second = i == j
                                    ? Vector3d((at(i, 1, i, 0) + at(i, -1, i, 0) - 2 * f_(z)) / (kStep * kStep))
                                    : Vector3d((at(i, 1, j, 1) + at(i, -1, j, -1) - at(i, 1, j, -1) - at(i, -1, j, 1)) /
                                               (4 * kStep * kStep));
        for (std::size_t a = 0; a < 3; ++a) h[a](i, j) = second[static_cast<Eigen::Index>(a)];
      }
    }
    for (std::size_t a = 0; a < 3; ++a) {
      e.trace[static_cast<Eigen::Index>(a)] = h[a].trace();
      e.along[a] = h[a] * (parts.directions.cols() > 0 ? parts.directions : MatrixXd(dimension_, 0));
      for (std::size_t b = 0; b < 3 && parts.squares; ++b)
        e.squares(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = h[a].cwiseProduct(h[b]).sum();
    }
    return e;
  }

 private:
  Eigen::Index dimension_;
  Function f_;
};

Centre centre_with_squares(const Chain& chain) {
  ExpansionParts parts;
  parts.squares = true;
  return centre_of(chain, parts);
}

/// A long hole of length R whose azimuth is in error by s z: its end goes along an arc. With E cos(k s z) =
/// exp(-k^2 s^2 / 2) all moments are known. Noise of its own is added to both.
struct Arc {
  static constexpr double R = 100, s = 0.3, noise = 2;
  static GivenChain chain() {
    return {3, [](const VectorXd& z) {
              return Vector3d(R * (std::cos(s * z[0]) - 1) + noise * z[1], R * std::sin(s * z[0]) + noise * z[2], 0);
            }};
  }
  static double e(double k) { return std::exp(-k * k * s * s / 2); }
  static double mean_north() { return R * (e(1) - 1); }
  static double variance_north() { return R * R * ((1 + e(2)) / 2 - e(1) * e(1)) + noise * noise; }
  static double variance_east() { return R * R * (1 - e(2)) / 2 + noise * noise; }
};

}  // namespace

TEST_CASE("Second order has the terms of second and fourth order in the sizes") {
  // Moments of polynomials of normals: (x^2)'s variance is 2, cov(x, x^3) is 3.
  const GivenChain chain(2, [](const VectorXd& z) {
    const double x = 0.1 * z[0], y = 0.2 * z[1];
    return Vector3d(x + x * y + 4 * x * x * x, y + x * x - 3 * y * y * x, 7);
  });
  const Moments m = second_order(chain);
  CHECK_THAT(m.mean[0], WithinAbs(0, 1e-8));
  CHECK_THAT(m.mean[1], WithinRel(0.01, 1e-6));
  CHECK_THAT(m.mean[2], WithinAbs(7, 1e-9));
  CHECK_THAT(m.covariance(0, 0), WithinRel(0.01 + 0.01 * 0.04 + 2 * 4 * 3 * 1e-4, 1e-5));
  CHECK_THAT(m.covariance(1, 1), WithinRel(0.04 + 2 * 1e-4, 1e-5));
  // cov(x, -3 y^2 x) = -3 * 0.04 * 0.01; nothing of y with the others
  CHECK_THAT(m.covariance(0, 1), WithinRel(-3 * 0.04 * 0.01, 1e-4));
  CHECK(m.covariance.row(2).norm() < 1e-9);
}

TEST_CASE("Cubature of degree 5 has mean and covariance of quadratic functions, sigma points the mean") {
  const GivenChain chain(4, [](const VectorXd& z) {
    return Vector3d(1 + z[0] + 0.3 * z[0] * z[1], z[1] - 0.2 * z[2] * z[2], 0.5 * z[2] + 0.1 * z[0] * z[3]);
  });
  const Centre centre = centre_with_squares(chain);
  const Moments second = second_order(chain, centre);
  const MatrixXd all = MatrixXd::Identity(4, 4);
  const SigmaPointMoments c = cubature5(chain, centre, all), u = unscented(chain, centre, all);
  CHECK(c.values == 33);
  CHECK(u.values == 9);
  CHECK((c.moments.mean - second.mean).norm() < 1e-6);
  CHECK((u.moments.mean - second.mean).norm() < 1e-6);
  CHECK((c.moments.covariance - second.covariance).norm() < 1e-5);
  CHECK(c.is_definite);
  // Of two of the directions, the others' first order and curvature stay.
  const SigmaPointMoments part = cubature5(chain, centre, all.leftCols(2));
  CHECK((part.moments.mean - second.mean).norm() < 1e-6);
  CHECK_THAT(part.moments.covariance(0, 0), WithinRel(second.covariance(0, 0), 1e-5));
  CHECK_THAT(part.moments.covariance(2, 2), WithinRel(0.25, 1e-5));
}

TEST_CASE("With eight directions the weight of the centre is -5/3, and the covariance may be none") {
  // At the centre |z| is 0, at all points sqrt 3: the variance is -5/3 * 8/3 of its square.
  const GivenChain chain(8, [](const VectorXd& z) { return Vector3d(std::sqrt(z.squaredNorm()), 0.01 * z[0], 0); });
  const Centre centre{chain.values(VectorXd::Zero(8)).col(0), {}, chain.expand(VectorXd::Ones(8), {}, {})};
  const SigmaPointMoments u = unscented(chain, centre, MatrixXd::Identity(8, 8));
  CHECK_FALSE(u.is_definite);
}

TEST_CASE("A mixture has the moments, quantiles and ellipses of its parts") {
  Matrix3d narrow = Matrix3d::Zero();
  narrow.diagonal() << 1, 4, 9;
  narrow(0, 1) = narrow(1, 0) = 0.8;
  const Mixture mixture{{0.7, {0, 1, 2}, narrow}, {0.3, {5, -1, 2}, 2 * narrow}};
  const Vector3d north = Vector3d::UnitX();
  const Shape s = shape_along(mixture, north);
  CHECK_THAT(s.mean, WithinRel(1.5, 1e-12));
  CHECK_THAT(s.sd * s.sd, WithinRel(0.7 * (1 + 2.25) + 0.3 * (2 + 12.25), 1e-12));
  CHECK_THAT(moments_of(mixture).covariance(0, 0), WithinRel(s.sd * s.sd, 1e-12));
  // third central moment: sum w (d^3 + 3 d v)
  CHECK_THAT(s.skewness * std::pow(s.sd, 3), WithinRel(0.7 * (-3.375 - 4.5) + 0.3 * (42.875 + 3 * 3.5 * 2), 1e-12));
  for (const double p : {1e-6, 0.02, 0.5, 0.977, 1 - 1e-6}) {
    const double x = quantile(mixture, north, p);
    const double below = 0.7 * stats::normal_upper_tail(0 - x, 1) + 0.3 * stats::normal_upper_tail(5 - x, std::sqrt(2));
    CHECK_THAT(below, WithinAbs(p, 1e-12));
  }
  CHECK_THAT(quantile({{1, {3, 0, 0}, 4 * Matrix3d::Identity()}}, north, 0.975), WithinRel(3 + 2 * 1.9599639845, 1e-9));

  // A normal in its own ellipse; one that is displaced and of another shape, by summing a grid.
  const Mixture own{{1, {1, 2, 3}, narrow}};
  const auto inside = inside_ellipse(own, {1, 2, 3}, narrow, {1, 2, 3});
  for (int k = 1; k <= 3; ++k)
    CHECK_THAT(inside[static_cast<std::size_t>(k - 1)], WithinAbs(1 - std::exp(-0.5 * k * k), 1e-6));
  const Eigen::Matrix2d c = narrow.topLeftCorner<2, 2>(), weight = c.inverse(),
                        part = 0.5 * c + Eigen::Matrix2d::Identity();
  const Eigen::Vector2d off(0.7, -1.1);
  double sum = 0;
  constexpr double h = 0.02;
  for (double x = -8; x < 8; x += h)
    for (double y = -9; y < 9; y += h) {
      const Eigen::Vector2d r(x, y);
      if (r.dot(weight * r) > 4) continue;
      sum += h * h * std::exp(-0.5 * (r - off).dot(part.inverse() * (r - off))) /
             (2 * kPi * std::sqrt(part.determinant()));
    }
  Matrix3d whole = Matrix3d::Zero();
  whole.topLeftCorner<2, 2>() = part;
  CHECK_THAT(inside_ellipse({{1, {off[0], off[1], 0}, whole}}, Vector3d::Zero(), narrow, {2})[0], WithinAbs(sum, 1e-3));
  Matrix3d flat = Matrix3d::Zero();
  flat(0, 0) = 1;
  CHECK(std::isnan(inside_ellipse(own, {0, 0, 0}, flat, {1})[0]));
}

TEST_CASE("The profile of an arc has its exact moments where second order no longer has") {
  const GivenChain chain = Arc::chain();
  const Centre centre = centre_with_squares(chain);
  const Profile p = profile(chain, centre);
  const Moments exact_by = moments_of(p.mixture);
  CHECK_THAT(exact_by.mean[0], WithinRel(Arc::mean_north(), 2e-4));
  CHECK_THAT(exact_by.covariance(0, 0), WithinRel(Arc::variance_north(), 2e-3));
  CHECK_THAT(exact_by.covariance(1, 1), WithinRel(Arc::variance_east(), 2e-3));
  CHECK(std::abs(second_order(chain, centre).covariance(0, 0) / Arc::variance_north() - 1) > 0.05);
  CHECK(std::abs(p.direction[0]) > 0.99);
  CHECK(p.jumps.empty());
  CHECK(p.nodes_left_out == 0);
  CHECK(p.t.size() == 241);
  // The distribution to the south is that of the arc and its noise, summed over a fine grid of the azimuth.
  const double x = quantile(p.mixture, Vector3d::UnitX(), 0.05);
  double below = 0;
  constexpr double h = 1e-3;
  for (double z = -8; z < 8; z += h)
    below += h * std::exp(-0.5 * z * z) / std::sqrt(2 * kPi) *
             stats::normal_upper_tail(Arc::R * (std::cos(Arc::s * z) - 1) - x, Arc::noise);
  CHECK_THAT(below, WithinAbs(0.05, 3e-4));
}

TEST_CASE("The density of a profile is the exact one where the path is all there is") {
  // F = t + t^2 / 8 rises from t = -4 on: x has the density phi(t) / (1 + t / 4) there.
  const GivenChain chain(1, [](const VectorXd& z) { return Vector3d(z[0] + z[0] * z[0] / 8, 0, 0); });
  ExpansionParts parts;
  parts.squares = true;
  const Mixture mixture = without_gaps(profile(chain, centre_of(chain, parts)));
  const Vector3d along = Vector3d::UnitX();
  for (double t = -2; t <= 3; t += 0.11) {
    const double exact = std::exp(-0.5 * t * t) / std::sqrt(2 * kPi) / (1 + t / 4);
    CHECK_THAT(density(mixture, along, t + t * t / 8), WithinRel(exact, 0.02));
  }
  for (const double p : {0.025, 0.3, 0.975}) {
    const double t = stats::normal_quantile(p);
    CHECK_THAT(quantile(mixture, along, p), WithinAbs(t + t * t / 8, 0.003 * (1 + t / 4)));
  }
}

TEST_CASE("A jump of the chain is found with its probability, and a wild node is left out") {
  const GivenChain chain(2, [](const VectorXd& z) {
    const double t = z[0], leap = t > 2.01 ? -40 : 0;
    // Beyond 3.5 a second normal suddenly matters a hundred times as much.
    return Vector3d(10 * t + leap, 0.5 * z[1] * (t > 3.5 ? 100 : 1), 0);
  });
  const Centre centre = centre_with_squares(chain);
  const Profile p = profile(chain, centre);
  REQUIRE(p.jumps.size() == 1);
  // v may point either way.
  const Jump& j = p.jumps.front();
  CHECK_THAT(std::abs(j.from) * std::abs(p.direction[0]), WithinAbs(2.01, 0.06));
  CHECK(std::abs(j.to) > std::abs(j.from));
  CHECK_THAT(j.leap[0], WithinAbs(-39.5, 1));
  CHECK_THAT(j.probability, WithinRel(0.0222, 0.1));
  CHECK(p.nodes_left_out == 1);
  const OrderVerdict v = order_needed(first_order(centre), second_order(chain, centre), p, Vector3d::UnitX(), 0.02);
  REQUIRE(v.jump.has_value());
  CHECK(v.order == Order::profile);
}

TEST_CASE("The order that is needed rises with the nonlinearity") {
  const auto order_of = [](double bend, double cubic) {
    const GivenChain chain(2, [=](const VectorXd& z) {
      return Vector3d(z[0] + bend * z[0] * z[0] + cubic * std::pow(z[0], 3) + 0.05 * z[1], 0.1 * z[0], 0);
    });
    const Centre centre = centre_with_squares(chain);
    return order_needed(first_order(centre), second_order(chain, centre), profile(chain, centre), Vector3d::UnitX(),
                        0.02);
  };
  CHECK(order_of(0.01, 0).order == Order::first);
  CHECK(order_of(0.101, 0).order == Order::second);
  CHECK(order_of(0.01, 0.1).order == Order::profile);
  // A mean of more than a tenth of the sd is none of first order.
  CHECK(order_of(0.07, 0).order == Order::first);
  CHECK_THAT(order_of(0.101, 0).m2, WithinRel(0.101, 0.01));
  // The vertical is at rest to first order.
  const GivenChain plane(2, [](const VectorXd& z) { return Vector3d(z[0], 0.3 * z[1], 1e-3 * z[0] * z[0]); });
  const Centre centre = centre_with_squares(plane);
  const OrderVerdict v =
      order_needed(first_order(centre), second_order(plane, centre), profile(plane, centre), Vector3d::UnitZ(), 0.02);
  CHECK(std::isinf(v.e2));
  CHECK(v.order != Order::first);
}

TEST_CASE("A chain without noise has a profile of one point") {
  const GivenChain chain(1, [](const VectorXd&) { return Vector3d(1, 2, 3); });
  const Profile p = profile(chain, centre_with_squares(chain));
  REQUIRE(p.mixture.size() == 1);
  CHECK(p.mixture[0].mean == Vector3d(1, 2, 3));
  CHECK(p.mixture[0].covariance.norm() < 1e-12);
}

TEST_CASE("At a tenth of the sizes all predictions agree") {
  const auto chain_of = [](double size) {
    return GivenChain(3, [size](const VectorXd& z) {
      const VectorXd x = size * z;
      return Vector3d(100 * (std::cos(0.1 * x[0]) - 1) + 20 * x[1], 100 * std::sin(0.1 * x[0]) + x[2], 5 * x[2]);
    });
  };
  const GivenChain chain = chain_of(0.1);
  const Centre centre = centre_with_squares(chain);
  const Moments first = first_order(centre), second = second_order(chain, centre);
  const Profile p = profile(chain, centre);
  const Moments profiled = moments_of(p.mixture);
  const SigmaPointMoments c = cubature5(chain, centre, MatrixXd::Identity(3, 3));
  for (int a = 0; a < 3; ++a) {
    CHECK_THAT(std::sqrt(second.covariance(a, a) / first.covariance(a, a)), WithinAbs(1, 1e-3));
    CHECK_THAT(std::sqrt(profiled.covariance(a, a) / second.covariance(a, a)), WithinAbs(1, 1e-4));
    CHECK_THAT(std::sqrt(c.moments.covariance(a, a) / second.covariance(a, a)), WithinAbs(1, 1e-4));
  }
}
