#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "reliability/parity.h"
#include "reliability/reliability_grid.h"
#include "reliability/station_response.h"
#include "reliability_cases.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::reliability;
using namespace surveymc::test;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

using Eigen::Index;
constexpr std::size_t kGz = index_of(Observation::gz), kBx = index_of(Observation::bx), kBz = index_of(Observation::bz);

struct Place {
  double inclination, toolface, azimuth;  // deg
};
StationResponse response_of(const AdjustmentModel& m, const Place& p) {
  return {m, station_sines(p.inclination, p.toolface, p.azimuth, m.field.dip / kDegree)};
}
survey::Attitude attitude_of(const Place& p) {
  return {p.inclination * kDegree, p.azimuth * kDegree, p.toolface * kDegree};
}
std::vector<AdjustmentModel> all_models() {
  return {model_of(AdjustmentMode::sse), model_of(AdjustmentMode::sse_axial), model_of(AdjustmentMode::mse_fixed),
          model_of(AdjustmentMode::mse_shared, false, 3), model_of(AdjustmentMode::mse_shared, true, 3)};
}
Observations error_in(std::size_t observation, double size) {
  Observations e{};
  e[observation] = size;
  return e;
}

/// Number of the observation of the first station, or of the reference, in the oracle.
Index row_of(const AdjustmentModel& m, std::size_t o) {
  const int stations = m.mode == AdjustmentMode::mse_shared ? m.stations : 1;
  return static_cast<Index>(o) + (o < kReadings ? 0 : 6 * (stations - 1));
}

}  // namespace

TEST_CASE("Residuals and effects of an error are those of least squares") {
  for (const AdjustmentModel& m : all_models())
    for (const Place& p : {Place{30, 45, 60}, Place{70, 120, 100}, Place{5, 200, 310}, Place{120, 33, 250},
                           Place{88, 271, 91}, Place{45, 0, 180}}) {
      const std::size_t stations = m.mode == AdjustmentMode::mse_shared ? static_cast<std::size_t>(m.stations) : 1;
      const LeastSquares l = least_squares(m, std::vector<survey::Attitude>(stations, attitude_of(p)));
      const StationResponse response = response_of(m, p);
      for (std::size_t o = 0; o < kObservations; ++o) {
        if (!is_observed(m.mode, o)) continue;
        const double sd = response.sd()[o], size = 7 * sd;
        const ErrorResponse r = response.of(error_in(o, size));
        INFO(adjustment_mode_names()[static_cast<std::size_t>(m.mode)]
             << " " << m.systematic_terms << " error in " << observation_names()[o] << " I " << p.inclination);
        for (std::size_t j = 0; j < kObservations; ++j) {
          if (!is_observed(m.mode, j)) {
            CHECK(std::isnan(r.residuals[j]));
            continue;
          }
          // The oracle's R is a difference from 1: 1e-9 of an error in sd
          const double expected = l.redundancy(row_of(m, j), row_of(m, o)) * size;
          CHECK_THAT(r.residuals[j], WithinAbs(expected, 1e-9 * 7 * response.sd()[j] + 1e-8 * std::abs(expected)));
        }
        check_effects(r, m, l, static_cast<int>(stations), row_of(m, o), size, 1e-8);
      }
    }
}

TEST_CASE("The information matrix has the redundancy numbers, and the correlations of the general adjustment") {
  for (const AdjustmentModel& m : all_models()) {
    const Place p{50, 20, 200};
    const std::size_t stations = m.mode == AdjustmentMode::mse_shared ? static_cast<std::size_t>(m.stations) : 1;
    const ParityModel parity = linear_model(m, std::vector<survey::Attitude>(stations, attitude_of(p)));
    const StationResponse::Matrix9 h = response_of(m, p).information();
    const Observations sd = response_of(m, p).sd();
    for (const std::size_t i : observed(m.mode))
      for (const std::size_t j : observed(m.mode)) {
        const double expected = sd[i] * sd[j] *
                                parity.columns.col(observation_number(m, stations, 0, i))
                                    .dot(parity.columns.col(observation_number(m, stations, 0, j)));
        CHECK_THAT(h(static_cast<Index>(i), static_cast<Index>(j)), WithinAbs(expected, 1e-10));
      }
  }
}

TEST_CASE("Effects of a detectable error are the external reliability of the maps") {
  for (const AdjustmentModel& m : all_models())
    for (const Place& p :
         {Place{0, 30, 20}, Place{30, 0, 0}, Place{90, 90, 90}, Place{180, 10, 300}, Place{61, 250, 5}}) {
      const ReliabilityMaps maps(m, {{1}, {75}, {p.inclination}, {p.toolface}, {p.azimuth}}, kLambda);
      const StationResponse response = response_of(m, p);
      for (const std::size_t o : observed(m.mode)) {
        const auto map = maps.values(
            {o},
            {MapQuantity::redundancy_number, MapQuantity::minimal_detectable_error, MapQuantity::external_inclination,
             MapQuantity::external_toolface, MapQuantity::external_azimuth},
            0, 1)[0];
        INFO(adjustment_mode_names()[static_cast<std::size_t>(m.mode)] << " " << observation_names()[o] << " I "
                                                                       << p.inclination);
        CHECK_THAT(response.information()(static_cast<Index>(o), static_cast<Index>(o)), WithinAbs(map[0][0], 1e-10));
        if (std::isinf(map[1][0])) continue;
        const ErrorResponse r = response.of(error_in(o, map[1][0] / observation_scale(o)));
        const double found[] = {r.inclination / kDegree, r.toolface / kDegree, r.azimuth / kDegree};
        for (std::size_t k = 0; k < 3; ++k) {
          if (std::isinf(map[2 + k][0]))
            CHECK(std::abs(found[k]) == std::abs(map[2 + k][0]));
          else
            CHECK_THAT(found[k], WithinAbs(map[2 + k][0], 1e-9));
        }
      }
    }
}

TEST_CASE("Figure 1: residuals of an accelerometer alone are those of eqs 27 to 33") {
  AdjustmentModel m = model_of(AdjustmentMode::mse_fixed);
  m.field.gravity = 9.8;
  m.sigma.magnetometer_noise = 1e5;  // sd of b/B 2, of g/G 3e-4: 2.4e-8 of the weight
  for (const double inclination : {0.0, 1e-8, 30.0, 54.735610317245346, 90.0, 120.0, 180.0}) {
    const ErrorResponse r = response_of(m, {inclination, 45, 0}).of(error_in(kGz, 0.05));
    const double si = std::sin(inclination * kDegree), ci = std::cos(inclination * kDegree), half = std::sqrt(0.5);
    CHECK_THAT(r.residuals[0], WithinAbs(-0.05 * ci * si * half, 1e-8));
    CHECK_THAT(r.residuals[1], WithinAbs(-0.05 * ci * si * half, 1e-8));
    CHECK_THAT(r.residuals[2], WithinAbs(0.05 * ci * ci, 1e-8));
    CHECK_THAT(r.inclination, WithinAbs(-0.05 / 9.8 * si, 1e-9));
  }
  const ErrorResponse equal = response_of(m, {54.735610317245346, 45, 0}).of(error_in(kGz, 0.05));
  CHECK_THAT(std::abs(equal.residuals[0]), WithinAbs(equal.residuals[2], 2e-9));
}

TEST_CASE("An error in readings and references at once is the sum of its parts") {
  const AdjustmentModel m = model_of(AdjustmentMode::mse_shared, true, 5);
  const StationResponse response = response_of(m, {40, 100, 250});
  Observations both{};
  both[kBz] = 300;
  both[8] = 0.002;
  const ErrorResponse a = response.of(error_in(kBz, 300)), b = response.of(error_in(8, 0.002)), sum = response.of(both);
  for (std::size_t j = 0; j < kObservations; ++j)
    CHECK_THAT(sum.residuals[j], WithinAbs(a.residuals[j] + b.residuals[j], 1e-9 * response.sd()[j]));
  CHECK_THAT(sum.azimuth, WithinAbs(a.azimuth + b.azimuth, 1e-12));
  CHECK_THAT(sum.dip, WithinAbs(a.dip + b.dip, 1e-12));
}

TEST_CASE("A field error towards magnetic east shows in no test, and turns the azimuth whole") {
  // It is at right angles to the field and to gravity: neither |b| nor the dip changes, while b turns by error/(B cosD)
  for (const AdjustmentModel& m : {model_of(AdjustmentMode::sse), model_of(AdjustmentMode::mse_fixed)})
    for (const Place& p : {Place{30, 45, 60}, Place{70, 120, 100}, Place{120, 33, 250}}) {
      const survey::Vec3<double> east = cross(survey::down_T(attitude_of(p)), survey::magnetic_T(attitude_of(p), 1, 0));
      Observations error{};
      error[3] = 1000 * east.x;
      error[4] = 1000 * east.y;
      error[5] = 1000 * east.z;
      const ErrorResponse r = response_of(m, p).of(error);
      for (const std::size_t j : observed(m.mode))
        CHECK_THAT(r.residuals[j], WithinAbs(0, 1e-10 * response_of(m, p).sd()[j]));
      CHECK_THAT(r.azimuth, WithinRel(-1000 / (m.field.total * std::cos(m.field.dip)), 1e-10));
      CHECK_THAT(r.inclination, WithinAbs(0, 1e-12));
    }
}

TEST_CASE("A vertical hole has no azimuth: effects are infinite, or nothing") {
  const StationResponse response = response_of(model_of(AdjustmentMode::sse), {180, 30, 20});
  const ErrorResponse lean = response.of(error_in(0, 0.05)), along = response.of(error_in(kGz, 0.05));
  CHECK(std::isinf(lean.toolface));
  CHECK(std::isinf(lean.azimuth));
  CHECK(std::isfinite(lean.inclination));
  CHECK(along.toolface == 0);
  CHECK_THAT(along.azimuth, WithinAbs(0, 1e-12));
  // Without bz, horizontal to the east: the azimuth is lost whatever the error is
  CHECK(std::isinf(response_of(model_of(AdjustmentMode::sse_axial), {90, 30, 90}).of(error_in(kBx, 100)).azimuth));
}

TEST_CASE("The weakest direction: nothing in its space shows less") {
  const StationResponse::Matrix9 h = response_of(model_of(AdjustmentMode::sse), {30, 45, 60}).information();
  const std::vector<Index> which{0, 3, 8};
  Eigen::MatrixXd part(3, 3);
  for (Index i = 0; i < 3; ++i)
    for (Index j = 0; j < 3; ++j)
      part(i, j) = h(which[static_cast<std::size_t>(i)], which[static_cast<std::size_t>(j)]);
  const WeakestDirection w = weakest_direction(part);
  CHECK(w.dimensions == 3);
  CHECK_THAT(w.direction.norm(), WithinAbs(1, 1e-12));
  CHECK_THAT(w.direction.dot(part * w.direction), WithinRel(w.redundancy, 1e-9));
  for (int k = 0; k < 50; ++k) {
    const Eigen::VectorXd other =
        Eigen::Vector3d(std::sin(1.0 + 3 * k), std::sin(2.0 + 5 * k), std::sin(3.0 + 7 * k)).normalized();
    CHECK(other.dot(part * other) >= w.redundancy * (1 - 1e-12));
  }
  // The same as from the general adjustment
  const ParityModel parity = linear_model({}, {attitude_of({30, 45, 60})});
  const WeakestCombination weak = weakest_combination(parity, which, kLambda);
  CHECK_THAT(kLambda / std::sqrt(w.redundancy), WithinRel(weak.detectable, 1e-9));
  CHECK_THAT((w.direction - weak.direction).norm(), WithinAbs(0, 1e-9));
}

TEST_CASE("Directions that show equally little: the one nearest to a single observation") {
  Eigen::MatrixXd none = Eigen::MatrixXd::Zero(3, 3);
  none(0, 0) = 0.4;
  const WeakestDirection w = weakest_direction(none);
  CHECK(w.redundancy == 0);
  CHECK(w.dimensions == 1);
  CHECK_THAT((w.direction - Eigen::Vector3d(0, 1, 0)).norm(), WithinAbs(0, 1e-12));
  // Entries of one size: the first is positive, whatever rounding makes of the eigenvector
  const WeakestDirection even = weakest_direction(Eigen::Matrix2d{{0.5, 0.2}, {0.2, 0.5}});
  CHECK_THAT((even.direction - Eigen::Vector2d(std::sqrt(0.5), -std::sqrt(0.5))).norm(), WithinAbs(0, 1e-12));
  CHECK(weakest_direction(Eigen::MatrixXd::Zero(2, 2)).dimensions == 0);
}
