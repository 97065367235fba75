#include <catch2/catch.hpp>

#include <cmath>

#include "reliability/adjustment.h"
#include "reliability/nonlinear_detectable.h"
#include "reliability/reliability_grid.h"
#include "reliability/significance.h"

using namespace surveymc;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr std::size_t kBx = index_of(Observation::bx), kDip = index_of(Observation::dip);
const double kLambda = lambda0({1e-4, Tails::one, 0.8});

Attitude degrees(double inclination, double toolface, double azimuth) {
  return {inclination * kDegree, azimuth * kDegree, toolface * kDegree};
}
AdjustmentModel shared_by(int stations, bool systematic) {
  AdjustmentModel m;
  m.mode = AdjustmentMode::mse_shared;
  m.stations = stations;
  m.systematic_terms = systematic;
  return m;
}

/// The oracle: all stations adjusted together, without linearisation, the error in the first one.
double shift_of_all(const AdjustmentModel& m, const Attitude& at, std::size_t observation, double nabla) {
  const Observations y = true_observations(at, m.field);
  std::array<double, kReadings> readings;
  std::copy_n(y.begin(), kReadings, readings.begin());
  StationReadings all{std::vector<std::array<double, kReadings>>(static_cast<std::size_t>(m.stations), readings),
                      {y[6], y[7], y[8]}};
  const Eigen::VectorXd variances = adjustment_variances(m, all.readings);
  (observation < kReadings ? all.readings[0][observation] : all.references[observation - kReadings]) += nabla;
  const StationAdjustment a = adjust(m, all, variances);
  REQUIRE(a.converged);
  return std::sqrt(a.omega);
}

}  // namespace

TEST_CASE("The shift in a shared adjustment is that of the adjustment of all its stations") {
  for (const bool systematic : {false, true})
    for (const int stations : {1, 2, 5})
      for (const Attitude& at : {degrees(30, 45, 60), degrees(30, 2, 2), degrees(90, 0, 90), degrees(0, 20, 10)}) {
        const AdjustmentModel m = shared_by(stations, systematic);
        const std::pair<std::size_t, double> errors[] = {{0, 0.04}, {2, -0.06}, {kBx, 1500}, {kBx, -2500},
                                                         {5, 900},  {6, -0.02}, {7, 400},    {kDip, 0.01}};
        for (const auto& [observation, nabla] : errors) {
          const double expected = shift_of_all(m, at, observation, nabla);
          INFO(stations << " stations, systematic " << systematic << ", " << observation_names()[observation] << " "
                        << nabla << ", I " << at.inclination / kDegree);
          // Both stop at steps of 1e-8 or 1e-9 sd; the shift is flat there, and 1e-7 is of its rounding
          CHECK_THAT(error_shift(m, at, observation, nabla), WithinAbs(expected, 1e-7 * (1 + expected)));
        }
      }
}

TEST_CASE("Small errors in a shared adjustment show as linear theory says") {
  for (const bool systematic : {false, true}) {
    const AdjustmentModel m = shared_by(30, systematic);
    const Attitude at = degrees(50, 20, 200);
    const auto linear = station_reliability(m, at, kLambda);
    for (std::size_t o = 0; o < kObservations; ++o) {
      const double small = 1e-3 * linear[o].detectable;  // curvature is of the order of its ratio to the field
      CHECK_THAT(error_shift(m, at, o, small), WithinRel(1e-3 * kLambda, 1e-4));
    }
  }
}

TEST_CASE("Nonlinear minimal detectable errors of multi-station modes near weak geometry") {
  for (const bool systematic : {false, true}) {
    const AdjustmentModel m = shared_by(3, systematic);
    for (const int sign : {1, -1})
      for (const Attitude& at : {degrees(30, 2, 2), degrees(30, 0, 0), degrees(70, 90, 60)}) {
        const double nabla = nonlinear_detectable_error(m, at, kBx, kLambda, sign);
        REQUIRE(std::isfinite(nabla));
        CHECK(nabla * sign > 0);
        CHECK_THAT(shift_of_all(m, at, kBx, nabla), WithinRel(kLambda, 1e-6));
      }
  }
  // Infinite in linear theory; and the sign counts where the station is near it
  CHECK(std::isinf(station_reliability(shared_by(3, false), degrees(30, 0, 0), kLambda)[kBx].detectable));
  const AdjustmentModel m = shared_by(30, false);
  const double plus = nonlinear_detectable_error(m, degrees(30, 2, 2), kBx, kLambda, 1),
               minus = nonlinear_detectable_error(m, degrees(30, 2, 2), kBx, kLambda, -1);
  CHECK(plus < 0.8 * -minus);
  // Many stations know the references: as if these were free of error
  AdjustmentModel fixed;
  fixed.mode = AdjustmentMode::mse_fixed;
  fixed.sigma = m.sigma;
  CHECK_THAT(nonlinear_detectable_error(shared_by(1'000'000, false), degrees(60, 30, 20), kBx, kLambda, 1),
             WithinRel(nonlinear_detectable_error(fixed, degrees(60, 30, 20), kBx, kLambda, 1), 1e-5));
}

TEST_CASE("A nonlinear error needs an observation that the mode has") {
  AdjustmentModel m;
  m.mode = AdjustmentMode::mse_fixed;
  CHECK_THROWS_AS(error_shift(m, degrees(30, 45, 60), kDip, 0.01), std::invalid_argument);
  m.mode = AdjustmentMode::sse_axial;
  CHECK_THROWS_AS(error_shift(m, degrees(30, 45, 60), 5, 100), std::invalid_argument);
}
