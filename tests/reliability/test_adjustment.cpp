#include <catch2/catch.hpp>

#include <cmath>
#include <complex>

#include "reliability/conditions.h"
#include "reliability/nonlinear_detectable.h"
#include "reliability/reliability_grid.h"
#include "reliability/snooping.h"
#include "reliability_cases.h"
#include "stats/linear_algebra.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::reliability;
using namespace surveymc::test;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Index;

namespace {

constexpr Index kBx = 3, kBy = 4, kField = 7, kDip = 8;

/// Readings of three shots of one station, the tool turned between them.
std::vector<std::array<double, 6>> three_shots(const survey::ReferenceField& field) {
  std::vector<std::array<double, 6>> y;
  for (const double toolface : {185.0, 261.0, 82.0}) y.push_back(readings_at(degrees(45, toolface, 100), field));
  return y;
}

/// The adjustment example of the specification: a gross error in bx at (30, 45, 60).
struct Example {
  AdjustmentModel model;
  StationReadings y{{{-3.4692854878283134, -3.478155434340272, 8.506320412817533, -4312.574622111543,
                      -21500.323830811158, 46175.87856417599}},
                    {9.8179, 51013.0, 1.3102535760571832}};
  Eigen::VectorXd variances = adjustment_variances(model, {readings_at(degrees(30, 45, 60), model.field)});
};

}  // namespace

TEST_CASE("Derivatives of the conditions by complex steps") {
  // The same three functions, of complex readings.
  using Complex = std::complex<double>;
  const auto conditions = [](const Eigen::VectorXcd& y) {
    const auto dot = [](auto a, auto b) -> Complex { return (a.array() * b.array()).sum(); };
    const Complex g = std::sqrt(dot(y.head(3), y.head(3))), b = std::sqrt(dot(y.tail(3), y.tail(3)));
    Eigen::VectorXcd f(3);
    f << g, b, std::asin(dot(y.head(3), y.tail(3)) / (g * b));
    return f;
  };
  Eigen::VectorXd y(6);
  y << -3.1, 4.4, 8.0, -4312.0, 21500.0, 46175.0;
  const Conditions c = station_conditions(y.data());
  CHECK_THAT((conditions(y).real() - c.values).norm(), WithinAbs(0, 1e-11));
  for (Index i = 0; i < 6; ++i) {
    Eigen::VectorXcd moved = y;
    moved[i] += Complex(0, 1e-25);
    CHECK_THAT((conditions(moved).imag() / 1e-25 - c.jacobian.col(i)).norm(),
               WithinAbs(0, 1e-14 * std::max(1.0, c.jacobian.col(i).norm())));
  }
}

TEST_CASE("The adjustment example of the specification") {
  const Example example;
  const StationAdjustment a = adjust(example.model, example.y, example.variances);
  REQUIRE(a.converged);
  CHECK_THAT(a.omega, WithinAbs(47.197233, 5e-7));
  CHECK_THAT(a.parity.omega(), WithinRel(a.omega, 1e-9));
  CHECK_THAT(a.residuals.cwiseAbs2().cwiseQuotient(example.variances).sum(), WithinRel(a.omega, 1e-9));
  const GeneralTest bx = general_test(a.parity, std::vector<Index>{kBx});
  CHECK(bx.rank == 1);
  CHECK_THAT(bx.chi_squared, WithinAbs(45.588335, 5e-7));
  CHECK_THAT(bx.fisher, WithinAbs(56.670237, 1e-6));  // of a difference that has five digits less
  CHECK_THAT(bx.tau_squared, WithinAbs(2.897733, 5e-7));
  CHECK_THAT(general_test(a.parity, std::vector<Index>{kBx, kField}).chi_squared, WithinAbs(46.654046, 5e-7));
  // The error sits in bx, yet the dip has the largest w: the largest statistic need not be the culprit.
  const Eigen::VectorXd w = w_statistics(a.parity);
  CHECK_THAT(std::abs(w[kDip]), WithinAbs(6.809, 5e-4));
  CHECK_THAT(std::abs(w[kBx]), WithinAbs(6.752, 5e-4));
  const SnoopingResult found = data_snooping(a.parity, kCritical);
  REQUIRE(found.rejected.size() == 1);
  CHECK(found.rejected[0] == SuspectGroup{kDip});
  CHECK_THAT(pope_statistics(a.parity)[kBx], WithinRel(std::sqrt(bx.tau_squared), 1e-9));
}

TEST_CASE("Tests agree with the paper's formulas on the residuals") {
  const Example example;
  const StationAdjustment a = adjust(example.model, example.y, example.variances);
  AdjustmentModel at_solution = example.model;
  at_solution.field = {a.references[0], a.references[1], a.references[2], 0, 0};
  // Design matrix at the solution; variances as in the adjustment, not of the adjusted readings
  LeastSquares l = least_squares(at_solution, a.attitudes);
  const Eigen::VectorXd p = example.variances.cwiseInverse();
  const Eigen::MatrixXd normal = l.design.transpose() * p.asDiagonal() * l.design;
  const Eigen::MatrixXd q_ee = Eigen::MatrixXd(example.variances.asDiagonal()) -
                               l.design * stats::symmetric_inverse(normal) * l.design.transpose();
  const Eigen::MatrixXd pqp = p.asDiagonal() * q_ee * p.asDiagonal();
  const Eigen::VectorXd pe = p.cwiseProduct(a.residuals);
  const Eigen::VectorXd w = w_statistics(a.parity), nabla = estimated_errors(a.parity),
                        r = redundancy_numbers(a.parity);
  for (Index i = 0; i < 9; ++i) {
    // The normal matrix has a condition of 1e12: its inverse has five digits in the weak observations
    CHECK_THAT(w[i], WithinAbs(pe[i] / std::sqrt(pqp(i, i)), 1e-6));
    CHECK_THAT(nabla[i], WithinRel(pe[i] / pqp(i, i), 1e-5));
    CHECK_THAT(r[i], WithinRel(q_ee(i, i) * p[i], 1e-5));
  }
  CHECK_THAT(r.sum(), WithinAbs(3, 1e-9));
  const Eigen::MatrixXd rho = test_correlations(a.parity);
  CHECK_THAT(rho(kBx, kDip), WithinAbs(pqp(kBx, kDip) / std::sqrt(pqp(kBx, kBx) * pqp(kDip, kDip)), 1e-6));
}

TEST_CASE("Error-free readings are adjusted to themselves, at every attitude and in every mode") {
  for (const AdjustmentMode mode : kAllModes)
    for (const survey::Attitude& at : difficult_attitudes()) {
      AdjustmentModel m = model_of(mode, mode == AdjustmentMode::mse_shared);
      // Without bz the azimuth is lost in a horizontal hole to the east or west, and close to it hardly determined.
      if (mode == AdjustmentMode::sse_axial && std::abs(std::cos(at.azimuth)) < 1e-4 &&
          std::abs(std::cos(at.inclination)) < 1e-4)
        continue;
      const auto y = readings_at(at, m.field);
      const StationAdjustment a = adjust(m, {{y}, references(m.field)}, adjustment_variances(m, {y}));
      INFO(adjustment_mode_names()[static_cast<std::size_t>(mode)]
           << " I " << at.inclination / kDegree << " tau " << at.toolface / kDegree << " A " << at.azimuth / kDegree);
      REQUIRE(a.converged);
      CHECK(a.omega < 1e-16);  // rounding: 1e-11 nT against sigmas of 65 nT and more, and the dip's 1e-16 rad / 2e-3
      CHECK_THAT(std::cos(a.attitudes[0].inclination), WithinAbs(std::cos(at.inclination), 1e-12));
    }
}

TEST_CASE("A gross error of any size goes into the estimate of the observation that is left out") {
  AdjustmentModel m = model_of(AdjustmentMode::mse_shared);
  std::vector<std::array<double, 6>> y = three_shots(m.field);
  const Eigen::VectorXd v = adjustment_variances(m, y);
  y[2][3] += 9000;
  const Index wrong = observation_number(m, 3, 2, 3);
  const StationAdjustment with = adjust(m, {y, references(m.field)}, v),
                          without_it = adjust(m, {y, references(m.field)}, v, {wrong});
  REQUIRE(without_it.converged);
  CHECK(with.omega > 100);
  CHECK(without_it.omega < 1e-12);
  CHECK_THAT(without_it.residuals[wrong], WithinRel(9000, 1e-9));
  CHECK_THAT(without_it.attitudes[2].azimuth / kDegree, WithinAbs(100, 1e-9));
  CHECK(without_it.parity.redundancy == 8);
}

TEST_CASE("The adjustment is stationary: no change of the unknowns lowers Omega") {
  AdjustmentModel m = model_of(AdjustmentMode::mse_shared, true);
  std::vector<std::array<double, 6>> y = three_shots(m.field);
  const Eigen::VectorXd v = adjustment_variances(m, y);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 6; ++i)
      y[k][i] += 2 * std::sqrt(v[static_cast<Index>(i)]) *
                 std::sin(7.0 * static_cast<double>(k) + 3.0 * static_cast<double>(i));
  const StationAdjustment a = adjust(m, {y, references(m.field)}, v);
  REQUIRE(a.converged);
  // e' P X = 0, with X along the adjusted observations: C (adjusted) spans what is orthogonal to it
  const Eigen::MatrixXd c = a.parity.columns;
  const Eigen::VectorXd pe = a.residuals.cwiseQuotient(v);
  const Eigen::MatrixXd q = c * v.asDiagonal() * c.transpose();
  const Eigen::VectorXd in_span = c.transpose() * (stats::symmetric_inverse(q) * (c * a.residuals));
  CHECK_THAT((pe - in_span).norm(), WithinAbs(0, 1e-6 * pe.norm()));
  CHECK(a.parity.observations() == 18 + 3 + 12);
}

TEST_CASE("In sse_axial bx, by, B and Theta are one group") {
  AdjustmentModel m = model_of(AdjustmentMode::sse_axial);
  const std::vector<SuspectGroup> groups = inseparable_groups(linear_model(m, {degrees(30, 45, 60)}));
  REQUIRE(std::find(groups.begin(), groups.end(), SuspectGroup{kBx, kBy, kField, kDip}) != groups.end());
  auto y = readings_at(degrees(30, 45, 60), m.field);
  const Eigen::VectorXd v = adjustment_variances(m, {y});
  y[3] += 4000;
  const SnoopingResult found = iterative_snooping(adjust(m, {{y}, references(m.field)}, v).parity, kCritical);
  REQUIRE(found.rejected.size() == 1);
  CHECK(found.rejected[0] == SuspectGroup{kBx, kBy, kField, kDip});
  CHECK(found.accepted);
}

TEST_CASE("Exhausted redundancy ends every strategy, without NaN") {
  const Example example;
  const ParityModel m = adjust(example.model, example.y, example.variances).parity;
  const double nothing_passes = 1e-9;
  for (const auto strategy : {iterative_snooping, iterative_snooping_with_readmission}) {
    const SnoopingResult r = strategy(m, nothing_passes);
    CHECK(r.exhausted);
    CHECK_FALSE(r.accepted);
    CHECK(r.rejected.size() == 3);
  }
  const ParityModel empty = without(m, {0, 3, 8});
  CHECK(empty.redundancy == 0);
  CHECK(w_statistics(empty).isZero());
  CHECK(redundancy_numbers(empty).isZero());
  CHECK(inseparable_groups(empty).empty());
  CHECK(data_snooping(empty, 1).rejected.empty());
  CHECK(pair_search(empty, 1).rejected.empty());
  // With one direction left all tests are the same
  const ParityModel one = without(m, {0, 3});
  CHECK(one.redundancy == 1);
  CHECK(inseparable_groups(one).size() == 1);
  CHECK(std::isinf(general_test(one, std::vector<Index>{kDip}).fisher));
}

TEST_CASE("Two errors of a rotational shot: what the strategies find") {
  // Without noise all is clear to the pair search; with it the study gross_error_detection gives rates.
  AdjustmentModel m = model_of(AdjustmentMode::mse_shared);
  m.rotational_shot = true;
  std::vector<std::array<double, 6>> y = three_shots(m.field);
  const Eigen::VectorXd v = adjustment_variances(m, y);
  y[2][1] += 0.1211;
  y[2][3] -= 761.8;
  const ParityModel p = adjust(m, {y, references(m.field)}, v).parity;
  const SnoopingResult pair = pair_search(p, kCritical);
  CHECK(pair.rejected == std::vector<SuspectGroup>{{13}, {15}});
  CHECK(pair.ties.empty());
  CHECK(pair.accepted);
  CHECK(data_snooping(p, kCritical).rejected.size() == 1);
  CHECK(iterative_snooping(p, kCritical).accepted);
}

TEST_CASE("Shots of one station share inclination and azimuth") {
  for (const bool systematic : {false, true})
    for (const double inclination : {0.0, 45.0, 90.0}) {
      AdjustmentModel m = model_of(AdjustmentMode::mse_shared, systematic);
      m.rotational_shot = true;
      std::vector<survey::Attitude> at;
      for (const double toolface : {185.0, 261.0, 82.0}) at.push_back(degrees(inclination, toolface, 100));
      // (6N + 3)/(N + 5): three shots have a redundancy of 13, and priors change nothing in that
      const ParityModel p = linear_model(m, at);
      CHECK(p.redundancy == 13);
      CHECK_THAT(redundancy_numbers(p).sum(), WithinAbs(13, 1e-8));
      if (inclination == 0) continue;  // the oracle has angles
      // The oracle: columns of I and of A of the three shots added up
      LeastSquares l = least_squares(m, at);
      for (Index k = 1; k < 3; ++k)
        for (const Index j : {0, 2}) {
          l.design.col(j) += l.design.col(3 * k + j);
          l.design.col(3 * k + j).setZero();
        }
      const Eigen::VectorXd root = l.variance.cwiseSqrt().cwiseInverse();
      Eigen::MatrixXd x = root.asDiagonal() * l.design;
      for (Index j = 0; j < x.cols(); ++j)
        if (x.col(j).norm() > 0) x.col(j).normalize();
      // Diagonal of the projector on the columns of x, some of which depend on others
      const stats::SingularValues of_rows = stats::singular_values(x.transpose());
      const Index rank = (of_rows.values.array() > 1e-10).count();
      for (Index i = 0; i < p.observations(); ++i)
        CHECK_THAT(redundancy_numbers(p)[i], WithinAbs(1 - of_rows.right.row(i).head(rank).squaredNorm(), 1e-9));
    }
}

TEST_CASE("Snooping of clean data rejects nothing") {
  const ParityModel m = linear_model({}, {degrees(30, 45, 60)});
  for (const auto strategy : {data_snooping, iterative_snooping, iterative_snooping_with_readmission, pair_search}) {
    const SnoopingResult r = strategy(m, kCritical);
    CHECK(r.rejected.empty());
    CHECK(r.accepted);
    CHECK_FALSE(r.exhausted);
  }
}

TEST_CASE("The weakest combination of three observations") {
  const ParityModel m = linear_model({}, {degrees(30, 45, 60)});
  const std::vector<Index> which{0, kBx, kDip};
  const WeakestCombination weak = weakest_combination(m, which, kLambda);
  CHECK_THAT(weak.direction.norm(), WithinAbs(1, 1e-12));
  Eigen::VectorXd z = Eigen::VectorXd::Zero(9);
  for (Index k = 0; k < 3; ++k)
    z[which[static_cast<std::size_t>(k)]] =
        weak.direction[k] * std::sqrt(m.variance[which[static_cast<std::size_t>(k)]]);
  CHECK_THAT(detectable_along(m, z, kLambda), WithinRel(weak.detectable, 1e-9));
  // Nothing in that space shows less: single observations show more
  for (const Index i : which) CHECK(kLambda / std::sqrt(redundancy_numbers(m)[i]) > 0.999 * kLambda);
  for (int k = 0; k < 20; ++k) {
    Eigen::VectorXd other = Eigen::VectorXd::Zero(9);
    for (std::size_t j = 0; j < 3; ++j) other[which[j]] = std::sin(1.0 + k * 3.0 + 5.0 * static_cast<double>(j));
    other /= other.norm();
    for (const Index i : which) other[i] *= std::sqrt(m.variance[i]);
    CHECK(detectable_along(m, other, kLambda) <= weak.detectable * (1 + 1e-9));
  }
}

TEST_CASE("The weakest combination of four observations is never detected: three conditions") {
  const ParityModel m = linear_model({}, {degrees(30, 45, 60)});
  CHECK(std::isinf(weakest_combination(m, {0, 3, 5, 8}, kLambda).detectable));
  // bx, by and the dip move only two of the conditions
  CHECK(std::isinf(weakest_combination(m, {kBx, kBy, kDip}, kLambda).detectable));
}

TEST_CASE("Nonlinear minimal detectable errors depend on the sign near weak geometry") {
  const AdjustmentModel m;
  const auto nabla = [&](double i, double t, double a, int sign) {
    return nonlinear_detectable_error(m, degrees(i, t, a), kBx, kLambda, sign);
  };
  CHECK_THAT(nabla(30, 2, 2, 1), WithinAbs(3623, 0.5));
  CHECK_THAT(nabla(30, 2, 2, -1), WithinAbs(-5455, 0.5));
  CHECK_THAT(nabla(30, 0, 0, 1), WithinAbs(4455, 0.5));
  CHECK_THAT(nabla(30, 0, 0, -1), WithinAbs(-4455, 0.5));
  // Linear theory there: 10310 nT and infinite. Where geometry is strong the two agree to second order.
  CHECK_THAT(station_reliability(m, degrees(30, 2, 2), kLambda)[kBx].detectable, WithinAbs(10310, 0.5));
  CHECK(std::isinf(station_reliability(m, degrees(30, 0, 0), kLambda)[kBx].detectable));
  CHECK_THAT(nabla(30, 45, 60, 1), WithinRel(689.04775, 0.01));
  CHECK_THAT(error_shift(m, degrees(30, 45, 60), kBx, 1).general, WithinRel(kLambda / 689.04775, 1e-3));
}

TEST_CASE("The shift of an error is that of the general adjustment") {
  for (const AdjustmentMode mode : kSingleModes) {
    AdjustmentModel m = model_of(mode);
    auto y = readings_at(degrees(50, 20, 200), m.field);
    const Eigen::VectorXd v = adjustment_variances(m, {y});
    y[4] += 1500;
    CHECK_THAT(error_shift(m, degrees(50, 20, 200), kBy, 1500).general,
               WithinRel(std::sqrt(adjust(m, {{y}, references(m.field)}, v).omega), 1e-8));
  }
}
