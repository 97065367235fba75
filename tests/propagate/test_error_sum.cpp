#include "propagate/error_sum.h"

#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::propagate;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Effects of the stations of three survey legs, and the own effect of the last station.
struct Effects {
  std::vector<std::vector<Vector3d>> legs;
  Vector3d star;
};
Effects effects() {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  Effects e;
  for (const int stations : {4, 1, 3}) {
    e.legs.emplace_back();
    for (int k = 0; k < stations; ++k) e.legs.back().push_back(draw());
  }
  e.star = draw();
  return e;
}

Matrix3d by_error_sum(const Effects& e, PropagationMode mode) {
  ErrorSum sum(mode);
  for (std::size_t l = 0; l < e.legs.size(); ++l) {
    if (l > 0) sum.end_leg();
    for (const Vector3d& x : e.legs[l]) sum.add(x);
  }
  return sum.covariance(e.star);
}

Matrix3d square(const Vector3d& x) { return x * x.transpose(); }

/// The covariance of sum_a x_a eps_a when eps_a, eps_b have correlation r(a, b): no rule of any mode is used.
template <class Correlation>
Matrix3d by_correlation(const Effects& e, const Correlation& r) {
  struct Term {
    std::size_t leg, station;
    Vector3d x;
  };
  std::vector<Term> terms;
  for (std::size_t l = 0; l < e.legs.size(); ++l)
    for (std::size_t k = 0; k < e.legs[l].size(); ++k) terms.push_back({l, k, e.legs[l][k]});
  terms.push_back({e.legs.size() - 1, e.legs.back().size(), e.star});
  Matrix3d c = Matrix3d::Zero();
  for (const Term& a : terms)
    for (const Term& b : terms) c += r(a, b) * a.x * b.x.transpose();
  return c;
}

}  // namespace

TEST_CASE("Errors join within a station, a survey leg or the well, as their mode says") {
  const Effects e = effects();
  const double tolerance = 1e-13 * by_error_sum(e, PropagationMode::global).trace();
  const auto station = [](const auto& a, const auto& b) {
    return a.leg == b.leg && a.station == b.station ? 1.0 : 0.0;
  };
  const auto leg = [](const auto& a, const auto& b) { return a.leg == b.leg ? 1.0 : 0.0; };
  const auto well = [](const auto&, const auto&) { return 1.0; };
  CHECK((by_error_sum(e, PropagationMode::random) - by_correlation(e, station)).cwiseAbs().maxCoeff() < tolerance);
  CHECK((by_error_sum(e, PropagationMode::systematic) - by_correlation(e, leg)).cwiseAbs().maxCoeff() < tolerance);
  CHECK((by_error_sum(e, PropagationMode::well) - by_correlation(e, well)).cwiseAbs().maxCoeff() < tolerance);
  CHECK((by_error_sum(e, PropagationMode::global) - by_correlation(e, well)).cwiseAbs().maxCoeff() < tolerance);
}

TEST_CASE("Before anything is added, a position has its own effect only") {
  const Vector3d e(1, -2, 3);
  for (const PropagationMode mode : {PropagationMode::random, PropagationMode::systematic, PropagationMode::well}) {
    ErrorSum sum(mode);
    CHECK(sum.covariance() == Matrix3d::Zero());
    CHECK(sum.covariance(e) == square(e));
    sum.end_leg();
    sum.add(e);
    CHECK(sum.covariance() == square(e));
  }
}
