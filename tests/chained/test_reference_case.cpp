/// The reference case of chained multistation, by every solver. Angles to 1e-9 deg, chain to 1e-6 mg and nT, standard
/// deviations to 1e-9 of themselves: the reference solutions agree among themselves to better than that.
#include <catch2/catch.hpp>

#include "chained/basic_solution.h"
#include "chained/batch.h"
#include "chained/smoother.h"
#include "chained_cases.h"

using namespace surveymc;
using namespace surveymc::chained;
using namespace surveymc::chained_case;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

/// With the prior standard deviations as the case's file has them, to nine digits.
Model case_model(ChainReferences references = ChainReferences::chained) {
  Model m = slide7(references);
  m.prior_sd = {0.10198039 * kMg,  82.462112512,  82.462112512,  0.624796263 * kMg, 0.624796263 * kMg,
                0.624796263 * kMg, 158.660480738, 158.660480738, 233.365077206};
  return m;
}

void check_angles(const Eigen::Matrix3d& frame, const std::array<double, 3>& expected) {
  const survey::Attitude at = attitude_of(frame);
  CHECK_THAT(at.inclination / kDegree, WithinAbs(expected[0], 1e-9));
  // The case measures toolface from x, and azimuth in (-180, 180]
  CHECK_THAT(std::remainder(at.toolface / kDegree - 90 - expected[1], 360.0), WithinAbs(0, 1e-9));
  CHECK_THAT(std::remainder(at.azimuth / kDegree - expected[2], 360.0), WithinAbs(0, 1e-9));
}
void check_chain(const StationEstimate& s, const std::array<double, 9>& expected) {
  for (int i = 0; i < 9; ++i)
    CHECK_THAT(s.chain[i] / unit_of_state(i), WithinAbs(expected[static_cast<std::size_t>(i)], 1e-6));
}
void check_angle_sd(const StationEstimate& s, const std::array<double, 3>& expected) {
  const Eigen::Vector3d sd = attitude_sd(s.frame, s.covariance.topLeftCorner<3, 3>()) / kDegree;
  CHECK_THAT(sd[0], WithinRel(expected[0], 1e-9));
  CHECK_THAT(sd[2], WithinRel(expected[1], 1e-9));
  CHECK_THAT(sd[1], WithinRel(expected[2], 1e-9));
}

void check_states(const Solution& s, const Rows<3>& angles, const Rows<9>& chain) {
  REQUIRE(s.converged);
  for (std::size_t k = 0; k < kStations; ++k) {
    check_angles(s.stations[k].frame, angles[k]);
    check_chain(s.stations[k], chain[k]);
  }
}

void check_smoother(const Solution& s) {
  check_states(s, kSmootherAngles, kSmootherChain);
  CHECK_THAT(s.cost, WithinAbs(kCost, 1e-9));
  for (std::size_t k = 0; k < kStations; ++k) {
    check_angle_sd(s.stations[k], kSmootherAngleSd[k]);
    for (int i = 0; i < 9; ++i)
      CHECK_THAT(std::sqrt(s.stations[k].covariance(3 + i, 3 + i)) / unit_of_state(i),
                 WithinRel(kSmootherChainSd[k][static_cast<std::size_t>(i)], 1e-9));
  }
}

}  // namespace

TEST_CASE("The chained reference case: single stations", "[chained]") {
  const Model m = slide7();
  const Readings r = case_readings();
  for (std::size_t k = 0; k < kStations; ++k) {
    const SingleStation basic = basic_station(r.y[k]), single = fully_optimised_station(m, single_weights(m), r.y[k]);
    check_angles(basic.frame, kBasicAngles[k]);
    check_angles(single.frame, kSingleAngles[k]);
    const std::array<double, 3> b{basic.gravity / kMg, basic.horizontal, basic.down},
        s{single.gravity / kMg, single.horizontal, single.down};
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK_THAT(b[i], WithinAbs(kBasicFields[k][i], 1e-6));
      CHECK_THAT(s[i], WithinAbs(kSingleFields[k][i], 1e-6));
    }
  }
}

TEST_CASE("The chained reference case: Levenberg, Gauss-Newton, Kalman smoother, lane kernel", "[chained]") {
  const Model m = case_model();
  const Readings r = case_readings();
  check_smoother(solve_blocks(m, r));
  check_smoother(solve_blocks(m, r, {.damped = false}));
  check_smoother(run_smoother(m, r));
  check_smoother(solve_alone(m, Mode::smoother, r.y));
}

TEST_CASE("The chained reference case: filter, references chained and independent", "[chained]") {
  const Readings r = case_readings();
  const Model chained = case_model(), independent = case_model(ChainReferences::independent);
  for (const Solution& s : {run_filter(chained, r), solve_alone(chained, Mode::filter, r.y)}) {
    check_states(s, kFilterAngles, kFilterChain);
    for (std::size_t k = 0; k < kStations; ++k) check_angle_sd(s.stations[k], kFilterAngleSd[k]);
  }
  for (const Solution& s : {run_filter(independent, r), solve_alone(independent, Mode::filter, r.y)})
    check_states(s, kFilterIndependentAngles, kFilterIndependentChain);
}
