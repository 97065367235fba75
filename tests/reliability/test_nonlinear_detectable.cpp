#include <catch2/catch.hpp>

#include <cmath>

#include "reliability/along_well.h"
#include "reliability/minimum.h"
#include "reliability/nonlinear_detectable.h"
#include "reliability/reliability_grid.h"
#include "reliability/station_response.h"
#include "reliability_cases.h"

using namespace surveymc;
using namespace surveymc::reliability;
using namespace surveymc::test;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr std::size_t kBx = index_of(Observation::bx), kDip = index_of(Observation::dip);
AdjustmentModel shared_by(int stations, bool systematic) {
  return model_of(AdjustmentMode::mse_shared, systematic, stations);
}

/// The oracle: all stations adjusted together, without linearisation, the error in the first one.
double shift_of_all(const AdjustmentModel& m, const survey::Attitude& at, std::size_t observation, double nabla) {
  StationReadings all{{static_cast<std::size_t>(m.stations), readings_at(at, m.field)}, references(m.field)};
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
      for (const survey::Attitude& at :
           {degrees(30, 45, 60), degrees(30, 2, 2), degrees(90, 0, 90), degrees(0, 20, 10)}) {
        const AdjustmentModel m = shared_by(stations, systematic);
        const std::pair<std::size_t, double> errors[] = {{0, 0.04}, {2, -0.06}, {kBx, 1500}, {kBx, -2500},
                                                         {5, 900},  {6, -0.02}, {7, 400},    {kDip, 0.01}};
        for (const auto& [observation, nabla] : errors) {
          const double expected = shift_of_all(m, at, observation, nabla);
          INFO(stations << " stations, systematic " << systematic << ", " << observation_names()[observation] << " "
                        << nabla << ", I " << at.inclination / kDegree);
          // Both stop at steps of 1e-8 or 1e-9 sd; the shift is flat there, and 1e-7 is of its rounding
          CHECK_THAT(error_shift(m, at, observation, nabla).general, WithinAbs(expected, 1e-7 * (1 + expected)));
        }
      }
}

TEST_CASE("Small errors in a shared adjustment show as linear theory says") {
  for (const bool systematic : {false, true}) {
    const AdjustmentModel m = shared_by(30, systematic);
    const survey::Attitude at = degrees(50, 20, 200);
    const auto linear = station_reliability(m, at, kLambda);
    for (std::size_t o = 0; o < kObservations; ++o) {
      const double small = 1e-3 * linear[o].detectable;  // curvature is of the order of its ratio to the field
      CHECK_THAT(error_shift(m, at, o, small).general, WithinRel(1e-3 * kLambda, 1e-4));
    }
  }
}

TEST_CASE("Nonlinear minimal detectable errors of multi-station modes near weak geometry") {
  for (const bool systematic : {false, true}) {
    const AdjustmentModel m = shared_by(3, systematic);
    for (const int sign : {1, -1})
      for (const survey::Attitude& at : {degrees(30, 2, 2), degrees(30, 0, 0), degrees(70, 90, 60)}) {
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
  AdjustmentModel fixed = model_of(AdjustmentMode::mse_fixed);
  fixed.sigma = m.sigma;
  CHECK_THAT(nonlinear_detectable_error(shared_by(1'000'000, false), degrees(60, 30, 20), kBx, kLambda, 1),
             WithinRel(nonlinear_detectable_error(fixed, degrees(60, 30, 20), kBx, kLambda, 1), 1e-5));
}

TEST_CASE("A nonlinear error needs an observation that the mode has") {
  AdjustmentModel m = model_of(AdjustmentMode::mse_fixed);
  CHECK_THROWS_AS(error_shift(m, degrees(30, 45, 60), kDip, 0.01), std::invalid_argument);
  m.mode = AdjustmentMode::sse_axial;
  CHECK_THROWS_AS(error_shift(m, degrees(30, 45, 60), 5, 100), std::invalid_argument);
}

TEST_CASE("Levenberg's steps and Gauss-Newton's end at the same minimum") {
  // Errors of up to 8 sd, all modes, attitudes with right angles among them; two and three stations as well
  int compared = 0;
  for (const AdjustmentMode mode : kAllModes)
    for (const bool systematic : {false, true})
      for (const bool shots : {false, true})
        for (const double inclination : {0.0, 1e-8, 40.0, 90.0, 135.0, 180.0}) {
          const bool shared = mode == AdjustmentMode::mse_shared;
          if (!shared && (systematic || shots)) continue;
          AdjustmentModel m = model_of(mode, systematic);
          m.rotational_shot = shots;
          StationReadings y{{}, references(m.field)};
          for (const double toolface : {20.0, 100.0, 250.0}) {
            if (!shared && !y.readings.empty()) break;
            y.readings.push_back(readings_at(degrees(inclination, toolface, 130), m.field));
          }
          const Eigen::VectorXd variances = adjustment_variances(m, y.readings);
          y.readings.front()[3] += 500;
          y.readings.back()[1] -= 0.03;
          const StationAdjustment a = adjust(m, y, variances);
          const Minimum b = minimum_of_omega(m, y, variances);
          INFO("mode " << int(mode) << " systematic " << systematic << " shots " << shots << " I " << inclination);
          REQUIRE(a.converged);
          REQUIRE(b.converged);
          // Within 1e-9 and 1e-7 sd of it, where Omega is flat; 1e-9 is of the rounding of residuals of 500 sd
          CHECK_THAT(b.omega, WithinRel(a.omega, 1e-9));
          ++compared;
        }
  CHECK(compared == 6 * (3 + 4));
}

TEST_CASE("Where Gauss-Newton goes round, the adjustment still converges, to a minimum") {
  AdjustmentModel m = model_of(AdjustmentMode::sse_axial);
  std::array<double, kReadings> y = readings_at(degrees(85, 45, 85), m.field);
  const Eigen::VectorXd variances = adjustment_variances(m, {y});
  y[kBx] += 673;
  const StationReadings readings{{y}, references(m.field)};
  const StationAdjustment a = adjust(m, readings, variances);
  REQUIRE(a.converged);
  // No other value of bz, which is free, nor of the tool's direction lowers Omega: a brute search over both
  const auto omega = [&](const survey::Attitude& at, double gravity, double total, double dip) {
    const survey::Vec3<double> g = scale(gravity, survey::down_T(at)), b = survey::magnetic_T(at, total, dip);
    const double e[] = {y[0] - g.x, y[1] - g.y, y[2] - g.z, y[3] - b.x, y[4] - b.y};
    double sum = 0;
    for (int i = 0; i < 5; ++i) sum += e[i] * e[i] / variances[i];
    return sum + std::pow(m.field.gravity - gravity, 2) / variances[6] +
           std::pow(m.field.total - total, 2) / variances[7] + std::pow(m.field.dip - dip, 2) / variances[8];
  };
  const survey::Attitude& best = a.attitudes.front();
  CHECK_THAT(omega(best, a.references[0], a.references[1], a.references[2]), WithinRel(a.omega, 1e-9));
  for (int i = 0; i < 6; ++i)
    for (const double h : {1e-4, -1e-4, 1e-2, -1e-2}) {
      survey::Attitude at = best;
      std::array<double, 3> r = a.references;
      double* unknown[] = {&at.inclination, &at.azimuth, &at.toolface, &r[0], &r[1], &r[2]};
      *unknown[i] *= 1 + h;
      CHECK(omega(at, r[0], r[1], r[2]) > a.omega);
    }
}

TEST_CASE("Minimal detectable errors in sse_axial are finite near horizontal") {
  AdjustmentModel m = model_of(AdjustmentMode::sse_axial);
  CHECK_THAT(nonlinear_detectable_error(m, degrees(85, 45, 85), kBx, kLambda, 1), WithinAbs(667.6, 0.05));
  for (const double inclination : {81.0, 87.0, 90.0})
    for (double toolface = 0; toolface < 180; toolface += 30)
      for (double azimuth = 0; azimuth <= 180; azimuth += 30)
        for (const int sign : {1, -1}) {
          const double nabla =
              nonlinear_detectable_error(m, degrees(inclination, toolface, azimuth), kBx, kLambda, sign);
          INFO(inclination << " " << toolface << " " << azimuth << " " << sign);
          REQUIRE(std::isfinite(nabla));
          // The bracket is 1e-10 of its size, and the shift at most 1e4 times as steep
          CHECK_THAT(error_shift(m, degrees(inclination, toolface, azimuth), kBx, nabla).general,
                     WithinRel(kLambda, 1e-6));
        }
}

TEST_CASE("Horizontal east or west in sse_axial, where no step moves bz, the shift is that of the minimum", "[long]") {
  AdjustmentModel m = model_of(AdjustmentMode::sse_axial, false, 1);
  const std::size_t by = index_of(Observation::by), total = index_of(Observation::total_field);
  // An error that makes the field too small for the readings is explained in part by a bz, an azimuth off east. Omega
  // is continuous in the azimuth, and Gauss-Newton is at no saddle 0.01 degrees off.
  for (const double east : {90.0, 270.0})
    for (const double toolface : {0.0, 30.0, 90.0, 135.0})
      for (const std::size_t observation : {std::size_t{0}, kBx, by, total, kDip})
        for (const int sign : {1, -1}) {
          INFO(east << " " << toolface << " " << observation_names()[observation] << " " << sign);
          const survey::Attitude at = degrees(90, toolface, east);
          const double size = nonlinear_detectable_error(m, at, observation, kLambda, sign);
          const double beside =
              nonlinear_detectable_error(m, degrees(90, toolface, east - 0.01), observation, kLambda, sign);
          if (std::isinf(beside)) {
            CHECK(std::isinf(size));
            continue;
          }
          CHECK_THAT(size, WithinRel(beside, 1e-5));
          CHECK_THAT(shift_of_all(m, at, observation, size), WithinRel(kLambda, 1e-6));
        }
  // Found at -0.774 degrees if bz stays where it is
  CHECK_THAT(nonlinear_detectable_error(m, degrees(90, 30, 90), kDip, kLambda, -1) / kDegree, WithinAbs(-2.5543, 1e-4));
}

TEST_CASE("In a vertical hole the inclination changes by the tilt, to whichever side it is") {
  for (const AdjustmentMode mode : {AdjustmentMode::sse, AdjustmentMode::mse_fixed, AdjustmentMode::mse_shared})
    for (const double inclination : {0.0, 180.0})
      for (const double toolface : {0.0, 30.0, 90.0})
        for (const std::size_t o : {std::size_t{0}, std::size_t{1}, kBx}) {
          AdjustmentModel m = model_of(mode, false, 1);
          const survey::Attitude at = degrees(inclination, toolface, 40);
          const double small = 1e-3 * kLambda;  // curvature is of the order of its ratio to the field
          const auto linear = station_reliability(m, at, small)[o];
          const double tilt =
              angle_effects(at, detected_error(m, at, o, small, 1, DetectedBy::general_test)).inclination;
          INFO("mode " << int(mode) << " I " << inclination << " toolface " << toolface << " "
                       << observation_names()[o]);
          CHECK_THAT(linear.inclination, WithinRel(tilt, 1e-3));
          const survey::Survey well{{{0, at.inclination, at.azimuth, at.toolface}}};
          CHECK_THAT(reliability_along_well(m, well, small).stations[0][o].inclination,
                     WithinRel(linear.inclination, 1e-9));
          Observations error{};
          error[o] = linear.detectable;
          const StationResponse response(m, station_sines(inclination, toolface, 40, m.field.dip / kDegree));
          CHECK_THAT(response.of(error).inclination, WithinRel(linear.inclination, 1e-9));
        }
}

TEST_CASE("An error that the general test finds may show in the tests of other readings") {
  const AdjustmentModel m;
  const survey::Attitude at = degrees(30, 12, 150);
  const double general = nonlinear_detectable_error(m, at, kBx, kLambda, -1),
               own = nonlinear_detectable_error(m, at, kBx, kLambda, -1, DetectedBy::own_test);
  CHECK_THAT(error_shift(m, at, kBx, general).general, WithinRel(kLambda, 1e-8));
  CHECK(error_shift(m, at, kBx, general).own < 0.5 * kLambda);
  CHECK_THAT(error_shift(m, at, kBx, own).own, WithinRel(kLambda, 1e-6));
  CHECK(own < 1.1 * general);
  for (double nabla = 200; nabla < 20000; nabla *= 1.3) {
    const TestShift shift = error_shift(m, at, kBx, -nabla);
    CHECK(shift.own <= shift.general * (1 + 1e-12));
  }
  // Where geometry is strong there is but one size, to 1 %
  CHECK_THAT(nonlinear_detectable_error(m, degrees(30, 45, 60), kBx, kLambda, 1, DetectedBy::own_test),
             WithinRel(nonlinear_detectable_error(m, degrees(30, 45, 60), kBx, kLambda, 1), 0.01));
}
