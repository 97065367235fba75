#include "estimate/observability.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "estimate/field_misfit.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::estimate;

namespace {
using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, 6>;

Jacobian jacobian_of(int number) {
  const test::ThesisCase c = test::thesis_case(number);
  return misfit_jacobian(field_misfits(test::station_fields(c), c.errors.gain, c.field.total, c.field.dip));
}
}  // namespace

TEST_CASE("Orthogonal columns of any length are perfectly observable") {
  Jacobian j = Jacobian::Zero(8, 6);
  for (int i = 0; i < 6; ++i) j(i, i) = std::pow(10.0, 3 * i - 8);  // units do not matter
  const Observability o = observability(j);
  for (int i = 0; i < 6; ++i) {
    CHECK(o.singular_values[i] == Approx(1).epsilon(1e-14));
    CHECK(o.condition_indices[i] == Approx(1).epsilon(1e-14));
    CHECK(o.variance_inflation[i] == Approx(1).epsilon(1e-14));
  }
}

TEST_CASE("Two columns at a small angle: the closed form") {
  // Columns a, a cos t + c sin t of unit length: singular values sqrt(1 -+ cos t) along (1, -+1)/sqrt 2.
  for (const double t : {0.3, 1e-2, 1e-4}) {
    Jacobian j = Jacobian::Identity(7, 6);
    j(2, 5) = std::cos(t);
    j(5, 5) = std::sin(t);
    const Observability o = observability(j);
    CAPTURE(t);
    const double weakest = std::sqrt(2.0) * std::sin(t / 2);  // sqrt(1 - cos t) without cancellation
    CHECK(o.singular_values[0] == Approx(weakest).epsilon(1e-14 / weakest));
    CHECK(o.condition_indices[0] == Approx(std::sqrt(1 + std::cos(t)) / weakest).epsilon(2e-14 / weakest));
    CHECK(combination_name(o.directions.col(0)).find("against") != std::string::npos);  // both columns point one way
    CHECK(std::abs(o.directions(2, 0)) == Approx(std::sqrt(0.5)).epsilon(1e-9));
    const double inflation = 1 / (std::sin(t) * std::sin(t));
    CHECK(o.variance_inflation[2] == Approx(inflation).epsilon(3e-14 / weakest));
    CHECK(o.variance_inflation[0] == Approx(1).epsilon(1e-14));
  }
}

TEST_CASE("Variance inflation is that of the unscaled covariance") {
  const Jacobian j = jacobian_of(4);
  const Observability o = observability(j);
  Eigen::Matrix<double, 6, 1> length = j.colwise().norm();
  const Jacobian unit = j * length.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd covariance = (unit.transpose() * unit).inverse();
  for (int i = 0; i < 6; ++i) CHECK(o.variance_inflation[i] == Approx(covariance(i, i)).epsilon(1e-10));
}

TEST_CASE("In all tests of the thesis the weakest combination is gain_z against bias_z") {
  for (int number = 1; number <= 4; ++number) {
    const Observability o = observability(jacobian_of(number));
    const std::string name = combination_name(o.directions.col(0));
    CAPTURE(number, name);
    CHECK(name == "gain_z against bias_z");
    CHECK(o.condition_indices[0] > 3 * o.condition_indices[1]);
  }
}

TEST_CASE("What nothing depends on, and what is the same, is not observable") {
  Jacobian none = Jacobian::Identity(7, 6);
  none.col(4).setZero();
  const Observability o = observability(none);
  CHECK(std::isinf(o.condition_indices[0]));
  CHECK(combination_name(o.directions.col(0)) == "bias_y");
  none.col(4).setConstant(1e-17);  // rounding
  CHECK(std::isinf(observability(none, Eigen::VectorXd::Ones(6)).condition_indices[0]));
  const Observability nothing = observability(Jacobian::Zero(7, 6));
  for (int i = 0; i < 6; ++i) CHECK(std::isinf(nothing.condition_indices[i]));
  // All stations alike: two independent residuals for six parameters.
  const test::ThesisCase c = test::thesis_case(4);
  const std::vector<survey::StationFields> same(20, test::station_fields(c).front());
  const Observability s = observability(misfit_jacobian(field_misfits(same, {1, 1, 1}, 51000, 72 * kDegree)));
  for (int i = 0; i < 4; ++i) CHECK(s.condition_indices[i] > kHopelessCondition);
  CHECK(s.condition_indices[5] == 1);
}

TEST_CASE("Combinations are named by their largest entries, with the sign between them") {
  Eigen::Matrix<double, 6, 1> d;
  d << 0, 0, 0.7, 0, 0, -0.71;
  CHECK(combination_name(d) == "gain_z against bias_z");
  d << 0.1, 0, 0.7, 0, 0, 0.6;
  CHECK(combination_name(d) == "gain_z with bias_z");
  d << -0.5, 0.3, 0, 0, 0.6, 0;
  CHECK(combination_name(d) == "gain_x against gain_y with bias_y");
}
