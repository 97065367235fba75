#include <catch2/catch.hpp>

#include <cmath>

#include "reliability/along_well.h"
#include "reliability/reliability_grid.h"
#include "reliability_cases.h"
#include "survey/minimum_curvature.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::reliability;
using namespace surveymc::test;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Index;

namespace {

/// Builds and turns, toolfaces all round.
survey::Survey a_well(int stations) {
  survey::Survey s;
  for (int k = 0; k < stations; ++k) {
    const double along = static_cast<double>(k) / stations;
    s.stations.push_back(
        {30.0 * k, (5 + 60 * along) * kDegree, (30 + 90 * along) * kDegree, std::fmod(137.5 * k, 360) * kDegree});
  }
  return s;
}

std::vector<survey::Attitude> attitudes(const survey::Survey& s, double declination) {
  std::vector<survey::Attitude> all;
  for (const survey::Station& station : s.stations) all.push_back(survey::magnetic_attitude(station, declination));
  return all;
}

Eigen::Vector3d end(const survey::Survey& s) { return survey::minimum_curvature_positions(s).back(); }

}  // namespace

TEST_CASE("Stations that share references: 3x3 systems against least squares of the whole well") {
  const survey::Survey well = a_well(5);
  for (const bool systematic : {false, true}) {
    AdjustmentModel m = model_of(AdjustmentMode::mse_shared, systematic);
    const LeastSquares l = least_squares(m, attitudes(well, 0));
    const WellReliability r = reliability_along_well(m, well, kLambda);
    double trace = 0;
    for (std::size_t k = 0; k < 5; ++k)
      for (std::size_t i = 0; i < kReadings; ++i) {
        const auto row = static_cast<Index>(6 * k + i);
        const StationEffect& e = r.stations[k][i];
        trace += e.redundancy;
        if (l.redundancy(row, row) < 1e-4) continue;
        CHECK_THAT(e.redundancy, WithinRel(l.redundancy(row, row), 1e-8));
        const double nabla = kLambda * std::sqrt(l.variance[row] / l.redundancy(row, row));
        CHECK_THAT(e.detectable, WithinRel(nabla, 1e-8));
        const double found[] = {e.inclination, e.toolface, e.azimuth};
        for (Index j = 0; j < 3; ++j)
          CHECK_THAT(found[j], WithinAbs(l.effect(3 * static_cast<Index>(k) + j, row) * nabla, 1e-9));
      }
    for (std::size_t j = 0; j < 3; ++j) {
      const auto row = static_cast<Index>(30 + j);
      trace += r.references[j].redundancy;
      CHECK_THAT(r.references[j].redundancy, WithinRel(l.redundancy(row, row), 1e-8));
    }
    if (!systematic) CHECK_THAT(trace, WithinAbs(15, 1e-9));
  }
}

TEST_CASE("The position moves as the attitudes of all stations do") {
  // Effects on I and A of every station, by least squares, carried through minimum curvature by finite differences.
  const survey::Survey well = a_well(4);
  AdjustmentModel m = model_of(AdjustmentMode::mse_shared, true);
  m.field.declination = 7 * kDegree;
  const LeastSquares l = least_squares(m, attitudes(well, m.field.declination));
  const WellReliability r = reliability_along_well(m, well, kLambda);
  const auto moved = [&](const Eigen::VectorXd& effect, double size) {
    const double h = 1e-6;
    survey::Survey up = well, down = well;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto at = static_cast<Index>(3 * k);
      up.stations[k].inclination += h * effect[at] * size;
      up.stations[k].azimuth += h * effect[at + 2] * size;
      down.stations[k].inclination -= h * effect[at] * size;
      down.stations[k].azimuth -= h * effect[at + 2] * size;
    }
    return Eigen::Vector3d((end(up) - end(down)) / (2 * h));
  };
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t i = 0; i < kReadings; ++i) {
      const StationEffect& e = r.stations[k][i];
      const Eigen::Vector3d expected = moved(l.effect.col(static_cast<Index>(6 * k + i)), e.detectable);
      CHECK_THAT((e.position - expected).norm(), WithinAbs(0, 1e-6));  // m; differences of 1e-12 m over 1e-6
    }
  for (std::size_t j = 0; j < 3; ++j)
    CHECK_THAT(
        (r.references[j].position - moved(l.effect.col(static_cast<Index>(24 + j)), r.references[j].detectable)).norm(),
        WithinAbs(0, 1e-6));
  // A common error is the sum of the columns
  for (std::size_t i = 0; i < kReadings; ++i) {
    Eigen::VectorXd z = Eigen::VectorXd::Zero(l.design.rows());
    for (Index k = 0; k < 4; ++k) z[6 * k + static_cast<Index>(i)] = 1;
    const double information = z.dot(l.variance.cwiseInverse().cwiseProduct(l.redundancy * z));
    CHECK_THAT(r.common[i].detectable, WithinRel(kLambda / std::sqrt(information), 1e-7));
    CHECK_THAT((r.common[i].position - moved(l.effect * z, r.common[i].detectable)).norm(), WithinAbs(0, 1e-5));
  }
}

TEST_CASE("Stations on their own are the points of the maps") {
  const survey::Survey well = a_well(6);
  for (const AdjustmentMode mode : kSingleModes) {
    AdjustmentModel m = model_of(mode);
    const WellReliability r = reliability_along_well(m, well, kLambda);
    for (std::size_t k = 0; k < 6; ++k) {
      const auto alone = station_reliability(m, attitudes(well, 0)[k], kLambda);
      for (const std::size_t o : observed(mode)) {
        INFO(observation_names()[o]);
        const StationEffect& e = r.stations[k][o];
        CHECK_THAT(e.redundancy, WithinAbs(alone[o].redundancy, 1e-10));
        CHECK_THAT(e.detectable, WithinRel(alone[o].detectable, 1e-8));
        CHECK_THAT(e.inclination, WithinAbs(alone[o].inclination, 1e-9));
        CHECK_THAT(e.toolface, WithinAbs(alone[o].toolface, 1e-8));
        CHECK_THAT(e.azimuth, WithinAbs(alone[o].azimuth, 1e-8));
      }
    }
  }
}

TEST_CASE("Many stations at one attitude are the kernel's mse_shared") {
  AdjustmentModel m = model_of(AdjustmentMode::mse_shared, true, 12);
  survey::Survey well;
  for (int k = 0; k < 12; ++k) well.stations.push_back({30.0 * k, 0.6, 1.9, 0.8});
  const auto alone = station_reliability(m, {0.6, 1.9, 0.8}, kLambda);
  const WellReliability r = reliability_along_well(m, well, kLambda);
  for (std::size_t i = 0; i < kReadings; ++i) {
    CHECK_THAT(r.stations[3][i].redundancy, WithinRel(alone[i].redundancy, 1e-9));
    CHECK_THAT(r.stations[3][i].azimuth, WithinAbs(alone[i].azimuth, 1e-9));
  }
  for (std::size_t j = 0; j < 3; ++j) CHECK_THAT(r.references[j].detectable, WithinRel(alone[6 + j].detectable, 1e-9));
}

TEST_CASE("A vertical station has an effect on the position, and none on angles it has not") {
  survey::Survey well = a_well(3);
  well.stations[1].inclination = 0;
  for (const AdjustmentMode mode : {AdjustmentMode::sse, AdjustmentMode::mse_shared}) {
    AdjustmentModel m = model_of(mode);
    const WellReliability r = reliability_along_well(m, well, kLambda);
    for (const std::size_t o : {2u, 3u, 4u, 5u}) {
      CHECK(std::isfinite(r.stations[1][o].detectable));
      CHECK(r.stations[1][o].position.allFinite());
      CHECK(std::isinf(r.stations[1][o].azimuth));
    }
  }
}

TEST_CASE("Where sse_axial loses the azimuth, the position is lost with it") {
  AdjustmentModel m = model_of(AdjustmentMode::sse_axial);
  m.field.declination = 0.1;
  for (const double toolface : {0.0, 30.0, 200.0})
    for (const double magnetic : {90.0, 270.0}) {
      survey::Survey well = a_well(3);
      survey::Station& lost = well.stations[1];
      lost.inclination = kPi / 2;
      lost.azimuth = magnetic * kDegree + m.field.declination;
      lost.toolface = toolface * kDegree;
      const WellReliability r = reliability_along_well(m, well, kLambda);
      const auto alone = station_reliability(m, attitudes(well, m.field.declination)[1], kLambda);
      for (const std::size_t o : observed(m.mode)) {
        INFO(observation_names()[o] << " " << toolface << " " << magnetic);
        const StationEffect& e = r.stations[1][o];
        CHECK_THAT(e.detectable, WithinRel(alone[o].detectable, 1e-8));
        CHECK(std::isinf(alone[o].azimuth));
        CHECK(e.azimuth == alone[o].azimuth);
        CHECK(std::isinf(e.position.norm()));
        CHECK(r.stations[0][o].position.allFinite());
        if (o < kReadings) CHECK(std::isinf(r.common[o].position.norm()));
      }
      // Without a course length on either side its azimuth moves nothing
      well.stations[0].md = well.stations[1].md = well.stations[2].md = 500;
      CHECK(reliability_along_well(m, well, kLambda).stations[1][index_of(Observation::dip)].position.norm() == 0);
    }
}

TEST_CASE("Errors that are just found, without linearisation: against the adjustment of the whole well") {
  // The near-vertical stations of a_well are where linear theory is worst. What is left is the curvature of the other
  // stations, whose adjusted readings move by tenths of their sd: parts in a thousand of the shift. The bound of the
  // position with systematic terms was set after it was seen: 0.8 % with four stations.
  const survey::Survey well = a_well(4);
  for (const bool systematic : {false, true}) {
    AdjustmentModel m = model_of(AdjustmentMode::mse_shared, systematic);
    m.field.declination = 7 * kDegree;
    StationReadings y{{}, references(m.field)};
    for (const survey::Attitude& at : attitudes(well, m.field.declination))
      y.readings.push_back(readings_at(at, m.field));
    const Eigen::VectorXd variances = adjustment_variances(m, y.readings);
    const WellErrors errors(m, well, kLambda, DetectedBy::general_test);
    for (std::size_t k = 0; k < 4; ++k)
      for (std::size_t i = 0; i < kReadings; ++i)
        for (const int sign : {1, -1}) {
          const FoundError found = errors.of(k, i, sign);
          INFO("systematic " << systematic << " station " << k << " " << observation_names()[i] << " " << found.size);
          REQUIRE(std::isfinite(found.size));
          CHECK(found.size * sign > 0);
          StationReadings with = y;
          with.readings[k][i] += found.size;
          const StationAdjustment a = adjust(m, with, variances);
          REQUIRE(a.converged);
          CHECK_THAT(std::sqrt(a.omega), WithinRel(kLambda, 5e-3));
          survey::Survey moved = well;
          for (std::size_t l = 0; l < 4; ++l) {
            moved.stations[l].inclination = a.attitudes[l].inclination;
            moved.stations[l].azimuth = a.attitudes[l].azimuth + m.field.declination;
          }
          const Eigen::Vector3d expected = end(moved) - end(well);
          CHECK_THAT((found.position - expected).norm(),
                     WithinAbs(0, (systematic ? 2e-2 : 5e-3) * (expected.norm() + 0.1)));
          CHECK(std::abs(found.azimuth) <= kPi);
          CHECK(std::abs(found.toolface) <= kPi);
        }
  }
}

TEST_CASE("On their own, errors that are just found are those of the maps, and small ones are linear") {
  const survey::Survey well = a_well(4);
  for (const AdjustmentMode mode : kSingleModes) {
    AdjustmentModel m = model_of(mode);
    const WellErrors errors(m, well, kLambda, DetectedBy::own_test);
    for (std::size_t k = 0; k < 4; ++k)
      for (const std::size_t o : observed(mode)) {
        const double size = errors.of(k, o, -1).size;
        const double expected =
            nonlinear_detectable_error(m, attitudes(well, 0)[k], o, kLambda, -1, DetectedBy::own_test);
        if (std::isfinite(expected)) CHECK_THAT(size, WithinRel(expected, 1e-7));
      }
    // A thousandth of lambda0: the curvature is of the order of its ratio to the field
    const WellErrors small(m, well, 1e-3 * kLambda, DetectedBy::general_test);
    const WellReliability linear = reliability_along_well(m, well, 1e-3 * kLambda);
    const FoundError e = small.of(2, 5 - (mode == AdjustmentMode::sse_axial), 1);
    const StationEffect& l = linear.stations[2][5 - (mode == AdjustmentMode::sse_axial)];
    CHECK_THAT(e.size, WithinRel(l.detectable, 2e-3));
    CHECK_THAT((e.position - l.position).norm(), WithinAbs(0, 5e-3 * l.position.norm()));
  }
  AdjustmentModel shared = model_of(AdjustmentMode::mse_shared);
  CHECK_THROWS_AS(WellErrors(shared, well, kLambda, DetectedBy::general_test).of(0, 7, 1), std::invalid_argument);
}
