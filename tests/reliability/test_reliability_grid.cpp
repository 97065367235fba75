#include <catch2/catch.hpp>

#include <cmath>
#include <cstdlib>

#include "reliability/reliability_grid.h"
#include "reliability_cases.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::reliability;
using namespace surveymc::test;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr std::size_t kBx = index_of(Observation::bx), kBz = index_of(Observation::bz);

/// Relative tolerance for r: the oracle loses the digits that X'PX has not, and r is a difference from 1 there.
void check_redundancy(double r, double expected) {
  if (expected >= 1e-3)
    CHECK_THAT(r, WithinRel(expected, 1e-9));
  else if (expected >= 1e-6)
    CHECK_THAT(r, WithinRel(expected, 1e-6));
  else
    CHECK_THAT(r, WithinAbs(expected, 1e-9));
}

void check_against_oracle(const AdjustmentModel& model, const survey::Attitude& at, int stations) {
  const LeastSquares l = least_squares(model, std::vector<survey::Attitude>(static_cast<std::size_t>(stations), at));
  const auto all = station_reliability(model, at, kLambda);
  for (std::size_t o = 0; o < kObservations; ++o) {
    if (!is_observed(model.mode, o)) {
      CHECK(std::isnan(all[o].redundancy));
      continue;
    }
    INFO(observation_names()[o] << " I " << at.inclination / kDegree << " tau " << at.toolface / kDegree << " A "
                                << at.azimuth / kDegree);
    const auto row = static_cast<Eigen::Index>(o < kReadings ? o : 6 * static_cast<std::size_t>(stations) + o - 6);
    const double r = l.redundancy(row, row);
    check_redundancy(all[o].redundancy, r);
    if (r < 1e-4) continue;  // beyond, the oracle has fewer digits than are compared
    const double nabla = kLambda * std::sqrt(l.variance[row] / r);
    CHECK_THAT(all[o].detectable, WithinRel(nabla, 1e-9));
    // An effect of less than 1e-9 of the standard deviation of the parameter is zero for both.
    check_effects(all[o], model, l, stations, row, nabla, 1e-9);
  }
}

std::vector<MapQuantity> all_quantities() {
  std::vector<MapQuantity> all;
  for (std::size_t q = 0; q < kMapQuantities; ++q) all.push_back(static_cast<MapQuantity>(q));
  return all;
}

std::vector<double> steps(double from, double to, double step) {
  std::vector<double> x;
  for (int i = 0; from + i * step <= to + 1e-9; ++i) x.push_back(from + i * step);
  return x;
}

}  // namespace

TEST_CASE("Redundancy, detectable error and effect on the azimuth at the attitudes of the specification") {
  const auto sse_bx = station_reliability(model_of(AdjustmentMode::sse), degrees(30, 45, 60), kLambda)[kBx];
  CHECK_THAT(sse_bx.redundancy, WithinAbs(0.43245831, 5e-9));
  CHECK_THAT(sse_bx.detectable, WithinAbs(689.04775, 5e-6));
  CHECK_THAT(sse_bx.azimuth / kDegree, WithinAbs(-0.593197, 5e-7));
  const auto sse_bz = station_reliability(model_of(AdjustmentMode::sse), degrees(70, 120, 100), kLambda)[kBz];
  CHECK_THAT(sse_bz.redundancy, WithinAbs(0.21188242, 5e-9));
  CHECK_THAT(sse_bz.detectable, WithinAbs(1795.82617, 5e-6));
  CHECK_THAT(sse_bz.azimuth / kDegree, WithinAbs(-6.246106, 5e-7));
  const auto mse_bx = station_reliability(model_of(AdjustmentMode::mse_fixed), degrees(60, 30, 20), kLambda)[kBx];
  CHECK_THAT(mse_bx.redundancy, WithinAbs(0.45114572, 5e-9));
  CHECK_THAT(mse_bx.detectable, WithinAbs(475.29713, 5e-6));
  CHECK_THAT(mse_bx.azimuth / kDegree, WithinAbs(1.505656, 5e-7));
}

TEST_CASE("Three conditions give what nine by six least squares gives") {
  const AdjustmentModel shared = model_of(AdjustmentMode::mse_shared, false, 4),
                        systematic = model_of(AdjustmentMode::mse_shared, true, 3);
  for (const survey::Attitude& at :
       {degrees(30, 45, 60), degrees(70, 120, 100), degrees(5, 200, 310), degrees(120, 33, 250), degrees(88, 271, 91),
        degrees(45, 0, 180), degrees(30, 90, 90), degrees(60, 10, 0.5)}) {
    for (const AdjustmentMode mode : kSingleModes) check_against_oracle(model_of(mode), at, 1);
    check_against_oracle(shared, at, 4);
    check_against_oracle(systematic, at, 3);
  }
}

TEST_CASE("Redundancy numbers add up to the redundancy") {
  for (const AdjustmentMode mode : kAllModes)
    for (const survey::Attitude& at : difficult_attitudes()) {
      AdjustmentModel m = model_of(mode, false, 7);
      // In a horizontal hole to the east or west the azimuth is lost with bz, and one unknown less leaves one more
      // redundancy: not the case meant here, nor its numerically close neighbours.
      if (mode == AdjustmentMode::sse_axial && std::abs(std::cos(at.azimuth) * std::sin(at.inclination)) < 1e-4 &&
          std::abs(std::cos(at.inclination)) < 1e-4)
        continue;
      double trace = 0;
      const auto all = station_reliability(m, at, kLambda);
      for (std::size_t o = 0; o < kObservations; ++o) {
        if (!is_observed(mode, o)) continue;
        const double copies = mode == AdjustmentMode::mse_shared && o < kReadings ? 7 : 1;
        trace += copies * all[o].redundancy;
        CHECK(all[o].redundancy >= 0);
        CHECK(all[o].redundancy <= 1 + 1e-12);
      }
      const double expected = mode == AdjustmentMode::mse_shared ? 21 : mode == AdjustmentMode::sse_axial ? 2 : 3;
      INFO(adjustment_mode_names()[static_cast<std::size_t>(mode)]
           << " I " << at.inclination / kDegree << " tau " << at.toolface / kDegree << " A " << at.azimuth / kDegree);
      // r below 1e-10 counts as 0: nine of them at most, times the stations
      CHECK_THAT(trace, WithinAbs(expected, mode == AdjustmentMode::mse_shared ? 7e-9 : 1e-9));
    }
}

TEST_CASE("Nothing is NaN at any attitude, and vertical holes have finite detectable errors") {
  for (const AdjustmentMode mode : kAllModes)
    for (const bool systematic : {false, true}) {
      AdjustmentModel m = model_of(mode, systematic);
      const ReliabilityGrid g{.dip_deg = {75, -60, 0},
                              .inclination_deg = {0, 1e-8, 30, 90, 179, 180},
                              .toolface_deg = {0, 45, 90, 180, 270, 360},
                              .magnetic_azimuth_deg = {0, 1e-8, 60, 90, 180, 270, 360}};
      const ReliabilityMaps maps(m, g, kLambda);
      const std::vector<MapQuantity> all = all_quantities();
      const auto values = maps.values(observed(mode), all, 0, g.points());
      for (const auto& of_observation : values)
        for (const auto& of_quantity : of_observation)
          for (const double x : of_quantity) REQUIRE_FALSE(std::isnan(x));
    }
  for (const double inclination : {0.0, 180.0}) {
    const auto all = station_reliability(model_of(AdjustmentMode::sse), degrees(inclination, 30, 20), kLambda);
    for (const std::size_t o : {2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
      CHECK(std::isfinite(all[o].detectable));
      CHECK(std::isfinite(all[o].inclination));
    }
    // A reading that leans the tool turns toolface and azimuth of a vertical hole without bound.
    const ReliabilityMaps maps(model_of(AdjustmentMode::sse), {{1}, {75}, {inclination}, {30}, {20}}, kLambda);
    const auto gx = maps.values({0}, {MapQuantity::external_toolface, MapQuantity::external_azimuth}, 0, 1)[0];
    CHECK(std::isinf(gx[0][0]));
    CHECK(std::isinf(gx[1][0]));
  }
}

TEST_CASE("Limits at a vertical hole are approached continuously") {
  for (const double end : {0.0, 180.0}) {
    const auto at = station_reliability(model_of(AdjustmentMode::sse), degrees(end, 30, 20), kLambda);
    const auto near =
        station_reliability(model_of(AdjustmentMode::sse), degrees(std::abs(end - 1e-6), 30, 20), kLambda);
    for (std::size_t o = 0; o < kObservations; ++o) {
      CHECK_THAT(near[o].redundancy, WithinAbs(at[o].redundancy, 1e-7));  // slope of order one per radian
      // At the end itself, by the tilt to any side; beside it, the part across turns the toolface instead
      const double tilt = std::hypot(near[o].inclination, near[o].toolface * std::sin(1e-6 * kDegree));
      CHECK_THAT(at[o].inclination, WithinAbs(end == 0 ? tilt : -tilt, 1e-7));
    }
  }
}

TEST_CASE("Exact symmetries of the maps") {
  for (const AdjustmentMode mode : kSingleModes)
    for (const double inclination : {0.5, 30.0, 70.0, 90.0, 133.0})
      for (const double toolface : {0.0, 17.0, 90.0, 200.0})
        for (const double azimuth : {3.0, 60.0, 179.0, 290.0}) {
          const auto a = station_reliability(model_of(mode), degrees(inclination, toolface, azimuth), kLambda);
          const auto turned =
              station_reliability(model_of(mode), degrees(inclination, toolface + 180, azimuth), kLambda);
          const auto mirrored = station_reliability(model_of(mode), degrees(inclination, -toolface, -azimuth), kLambda);
          const auto quarter =
              station_reliability(model_of(mode), degrees(inclination, toolface + 90, azimuth), kLambda);
          for (std::size_t o = 0; o < kReadings; ++o) {
            if (!is_observed(mode, o)) continue;
            if (a[o].redundancy < 1e-3) continue;  // rounding of the angles themselves shows below
            CHECK_THAT(turned[o].redundancy, WithinRel(a[o].redundancy, 1e-11));
            CHECK_THAT(turned[o].azimuth, WithinAbs((o % 3 == 2 ? 1 : -1) * a[o].azimuth, 1e-9));
            CHECK_THAT(mirrored[o].redundancy, WithinRel(a[o].redundancy, 1e-11));
          }
          if (a[kBx].redundancy > 1e-3) {
            // by at tau is bx at tau + 90
            CHECK_THAT(quarter[kBx].redundancy, WithinRel(a[kBx + 1].redundancy, 1e-11));
            CHECK_THAT(quarter[0].redundancy, WithinAbs(a[1].redundancy, 1e-12));
          }
        }
}

TEST_CASE("A missing bz is a bz with an unknown bias") {
  AdjustmentModel loose = model_of(AdjustmentMode::sse);
  loose.sigma.axial_interference = 1e6;  // nT: what is left of bz is (700 nT / 1e6 nT)^2 = 5e-7 of a redundancy of 1
  for (const survey::Attitude& at : {degrees(30, 45, 60), degrees(70, 120, 100), degrees(85, 10, 300)}) {
    const auto without = station_reliability(model_of(AdjustmentMode::sse_axial), at, kLambda);
    const auto unknown = station_reliability(loose, at, kLambda);
    for (std::size_t o = 0; o < kObservations; ++o) {
      if (o == kBz) continue;
      CHECK_THAT(without[o].redundancy, WithinAbs(unknown[o].redundancy, 1e-6));
      CHECK_THAT(without[o].azimuth, WithinRel(unknown[o].azimuth, 1e-3));
    }
  }
}

TEST_CASE("Maps of bx: number of infinite points, minima of the specification") {
  ReliabilityGrid g;
  g.dip_deg = {75};
  g.toolface_deg = g.magnetic_azimuth_deg = steps(0, 180, 1);
  struct Expected {
    AdjustmentMode mode;
    double inclination;
    int infinite;
    double minimum;
  };
  for (const Expected& e :
       {Expected{AdjustmentMode::sse, 30, 4, 661.2}, Expected{AdjustmentMode::sse, 70, 4, 653.5},
        Expected{AdjustmentMode::sse_axial, 30, 5, 0}, Expected{AdjustmentMode::sse_axial, 70, 5, 0},
        Expected{AdjustmentMode::mse_fixed, 30, 4, 323.1}, Expected{AdjustmentMode::mse_fixed, 70, 4, 319.3},
        Expected{AdjustmentMode::mse_shared, 30, 4, 328.5}, Expected{AdjustmentMode::mse_shared, 70, 4, 324.6}}) {
    g.inclination_deg = {e.inclination};
    const auto nabla = ReliabilityMaps(model_of(e.mode), g, kLambda)
                           .values({kBx}, {MapQuantity::minimal_detectable_error}, 0, g.points())[0][0];
    int infinite = 0;
    double minimum = 1e9;
    for (const double x : nabla) {
      infinite += std::isinf(x);
      minimum = std::min(minimum, x);
    }
    CHECK(infinite == e.infinite);
    if (e.minimum > 0) CHECK_THAT(minimum, WithinAbs(e.minimum, 0.05));
  }
}

TEST_CASE("A map is the same bits in slabs, in lanes and alone") {
  AdjustmentModel m = model_of(AdjustmentMode::mse_shared, true);
  const ReliabilityGrid g{{0.5, 1}, {70, 75}, {0, 20, 90}, steps(0, 350, 50), steps(0, 355, 5)};
  const std::vector<MapQuantity> all = all_quantities();
  const ReliabilityMaps maps(m, g, kLambda);
  const auto whole = maps.values(observed(m.mode), all, 0, g.points());
  for (const std::size_t first : {std::size_t{0}, std::size_t{1}, std::size_t{777}, g.points() - 3}) {
    const std::size_t count = std::min<std::size_t>(1001, g.points() - first);
    const auto part = maps.values({kBx}, all, first, count)[0];
    for (std::size_t q = 0; q < kMapQuantities; ++q)
      for (std::size_t p = 0; p < count; ++p) REQUIRE(part[q][p] == whole[kBx][q][first + p]);
  }
}

TEST_CASE(
    "A map has the bits of one station where observations are far more or less certain than those of any sensor") {
  // Lanes may take roots by products (simd/root.h), which are right in a range; the information about an observation
  // leaves it here, to infinity where the smallest determinant is no more a number above 0.
  for (const double factor : {1e-60, 1e-50, 1e-30, 1.0, 1e30, 1e50, 1e60}) {
    AdjustmentModel m = model_of(AdjustmentMode::sse);
    m.field.dip = 40 * kDegree;
    SigmaModel& s = m.sigma;
    for (double* sd :
         {&s.accelerometer_bias, &s.accelerometer_scale, &s.accelerometer_noise, &s.magnetometer_bias,
          &s.magnetometer_scale, &s.magnetometer_noise, &s.axial_interference, &s.gravity, &s.total_field, &s.dip})
      *sd *= factor;
    const std::vector<double> toolfaces = steps(1, 31, 1);
    const ReliabilityMaps maps(m, {{1}, {40}, {10}, toolfaces, {20}}, kLambda);
    const auto values = maps.values(
        observed(m.mode), {MapQuantity::redundancy_number, MapQuantity::minimal_detectable_error}, 0, toolfaces.size());
    int different = 0;
    for (std::size_t p = 0; p < toolfaces.size(); ++p) {
      const auto station = station_reliability(m, degrees(10, toolfaces[p], 20), kLambda);
      const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
      for (std::size_t o = 0; o < kReadings; ++o)
        different += !same(values[o][0][p], station[o].redundancy) + !same(values[o][1][p], station[o].detectable);
    }
    INFO("factor " << factor);
    CHECK(different == 0);
  }
}

TEST_CASE("A map in long columns is the same bits as one in vectors") {
  // Two variants of the kernel: one asks every output whether it is wanted, the other has five quantities of every
  // observation. Attitudes include those where an observation is not controlled.
  const ReliabilityGrid g{{0.5, 1}, {75}, {0, 30, 90}, steps(0, 350, 70), steps(0, 350, 10)};
  const std::vector<MapQuantity> all = all_quantities();
  const std::vector<MapQuantity> five(all.begin(), all.begin() + 5);
  MapValues columns;
  int compared = 0, infinite = 0;
  for (const AdjustmentMode mode : kAllModes)
    for (const bool systematic : {false, true}) {
      AdjustmentModel m = model_of(mode, systematic);
      const ReliabilityMaps maps(m, g, kLambda);
      const auto which = observed(mode);
      const auto whole = maps.values(which, all, 0, g.points());
      for (const std::size_t first : {std::size_t{0}, std::size_t{333}})
        for (const auto& quantities : {all, five}) {
          const std::size_t count = g.points() - first - first / 100;
          maps.fill(which, quantities, first, count, columns);
          REQUIRE(columns.points() == count);
          int different = 0;
          for (std::size_t o = 0; o < which.size(); ++o)
            for (std::size_t q = 0; q < quantities.size(); ++q)
              for (std::size_t p = 0; p < count; ++p, ++compared) {
                const double x = whole[o][q][first + p];
                different += columns.column(o, q)[p] != x;
                infinite += std::isinf(x);
              }
          CHECK(different == 0);
        }
    }
  CHECK(compared > 1000000);
  CHECK(infinite > 1000);
}
