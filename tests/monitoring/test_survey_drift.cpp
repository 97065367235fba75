#include "monitoring/survey_drift.h"

#include <random>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "survey/frames.h"

using namespace surveymc;
using namespace surveymc::monitoring;
using Catch::Matchers::WithinAbs;

TEST_CASE("Channels of an error-free station are the reference, at any attitude", "[monitoring]") {
  for (const double inclination : {0.0, 1e-8, 45.0, 90.0, 180.0})
    for (const double azimuth : {0.0, 91.0, 270.0})
      for (const double toolface : {0.0, 123.0}) {
        const survey::Attitude at{inclination * kDegree, azimuth * kDegree, toolface * kDegree};
        const Eigen::Vector3d g = 9.8 * survey::to_eigen(survey::down_T(at)),
                              b = survey::to_eigen(survey::magnetic_T(at, 50000, 72 * kDegree));
        const Eigen::Vector3d c = survey_channels(g, b);
        CHECK_THAT(c[0], WithinAbs(9.8, 1e-14));
        CHECK_THAT(c[1], WithinAbs(50000, 1e-10));
        CHECK_THAT(c[2], WithinAbs(72 * kDegree, 1e-14));
      }
}

TEST_CASE("The Jacobian of the channels equals central differences", "[monitoring]") {
  std::mt19937_64 gen(30);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int t = 0; t < 200; ++t) {
    const survey::Attitude at{kPi * std::abs(u(gen)), kPi * u(gen), kPi * u(gen)};
    const Eigen::Vector3d g = 9.8 * survey::to_eigen(survey::down_T(at)),
                          b = 50 * survey::to_eigen(survey::magnetic_T(at, 1, 1.2 * u(gen)));
    const ChannelJacobian h = survey_channel_jacobian(g, b);
    for (int j = 0; j < 6; ++j) {
      // Steps of 1e-5: truncation 1e-10 of third derivatives (up to 1 / cos^3 1.2 / 9.8^3), rounding 1e-15 / 1e-5.
      const double step = 1e-5;
      Eigen::Vector3d gp = g, gm = g, bp = b, bm = b;
      (j < 3 ? gp : bp)[j % 3] += step;
      (j < 3 ? gm : bm)[j % 3] -= step;
      const Eigen::Vector3d d = (survey_channels(gp, bp) - survey_channels(gm, bm)) / (2 * step);
      CHECK((d - h.col(j)).cwiseAbs().maxCoeff() < 2e-9);
    }
  }
}

TEST_CASE("A step of the bias filter is the weighted least-squares estimate from prior and station", "[monitoring]") {
  std::mt19937_64 gen(31);
  std::normal_distribution<double> n;
  const Vector6 walk = Vector6::Constant(0.5);
  const Eigen::Matrix3d r = Eigen::Vector3d(.1, .2, .3).asDiagonal();
  BiasFilter filter(walk);
  Matrix6 covariance = Matrix6::Zero();
  Vector6 bias = Vector6::Zero();
  for (int k = 0; k < 30; ++k) {
    ChannelJacobian h;
    for (int i = 0; i < 18; ++i) h.data()[i] = n(gen);
    const Eigen::Vector3d y(n(gen), n(gen), n(gen));
    covariance.diagonal() += walk;
    const Eigen::Vector3d v = y - h * bias;
    const double nis = v.dot((h * covariance * h.transpose() + r).inverse() * v);
    const Matrix6 prior = covariance.inverse();
    covariance = (prior + h.transpose() * r.inverse() * h).inverse();
    bias = covariance * (prior * bias + h.transpose() * r.inverse() * y);
    REQUIRE(filter.update(y, h, r) == Approx(nis).epsilon(1e-9));
    // Matrices of condition 1e3 here: 1e-13 each step, which later ones forget.
    REQUIRE((filter.covariance() - covariance).cwiseAbs().maxCoeff() < 1e-11);
    REQUIRE((filter.bias() - bias).cwiseAbs().maxCoeff() < 1e-11);
  }
}

TEST_CASE("The normalised error does not depend on the units of the sensors", "[monitoring]") {
  std::mt19937_64 gen(32);
  std::normal_distribution<double> n;
  Matrix6 a;
  for (int i = 0; i < 36; ++i) a.data()[i] = n(gen);
  const Matrix6 p = a * a.transpose() + Matrix6::Identity();
  const Vector6 e = a.col(0), units = (Vector6() << 1e-5, 1e-5, 1e-5, 1e4, 1e4, 1e4).finished();
  const double nees = e.dot(p.inverse() * e);
  CHECK(normalised_error(e, p) == Approx(nees).epsilon(1e-10));
  CHECK(normalised_error(units.cwiseProduct(e), units.asDiagonal() * p * units.asDiagonal()) ==
        Approx(nees).epsilon(1e-10));
}
