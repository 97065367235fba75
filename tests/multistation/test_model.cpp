#include "multistation/model.h"

#include <cmath>
#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "field.h"

using namespace surveymc;
using namespace surveymc::multistation;
using Eigen::Vector3d;
using test::kDip, test::kGravity, test::kTotal;

namespace {

struct Case {
  StationReadings station;
  PerParameter<double> tool;
};
/// A tool with errors of three priors at a random attitude, and trial parameters that are others.
Case random_case(std::mt19937_64& random, ResidualKind kind) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> angle(0, 2 * kPi);
  Case c;
  for (std::size_t i = 0; i < kParameters; ++i) c.tool[i] = 3 * normal(random) * kTable[i].prior_sd;
  const survey::Attitude at{0.5 * angle(random), angle(random), angle(random)};
  c.station =
      readings_of(c.tool, kGravity * survey::to_eigen(survey::down_T(at)),
                  survey::to_eigen(survey::magnetic_T(at, kTotal, kDip)), reference_of(kind, kGravity, kTotal, kDip));
  return c;
}

}  // namespace

TEST_CASE("The true parameters leave no residual") {
  std::mt19937_64 random(1);
  for (const ResidualKind kind : {ResidualKind::survey, ResidualKind::calibration})
    for (int i = 0; i < 50; ++i) {
      const Case c = random_case(random, kind);
      // Of readings of 5e4 nT and 10 m/s2 some units in the last place.
      const Vector3d r = station_residual(c.station, c.tool, kind, {1, 1, 1});
      CHECK(r.cwiseAbs().maxCoeff() < 1e-9);
    }
}

TEST_CASE("Every derivative is that of finite differences") {
  std::mt19937_64 random(2);
  const ResidualSizes sizes{0.006, 70, 50};
  for (const ResidualKind kind : {ResidualKind::survey, ResidualKind::calibration})
    for (int trial = 0; trial < 20; ++trial) {
      const Case c = random_case(random, kind);
      PerParameter<double> at{};  // not at the truth: residuals do not vanish
      for (std::size_t i = 0; i < kParameters; ++i) at[i] = 0.3 * c.tool[i];
      const StationModel m = station_model(c.station, at, kind, sizes);
      // Fourth-order differences: h^4 of the model's fifth derivative, and rounding of 1e-11 over h.
      const auto difference = [&](auto moved, double h) -> Vector3d {
        return (8 * (moved(h) - moved(-h)) - (moved(2 * h) - moved(-2 * h))) / (12 * h);
      };
      for (int i = 0; i < kParameters; ++i) {
        const double h = parameter(i).prior_sd;
        const Vector3d d = difference(
            [&](double by) {
              PerParameter<double> p = at;
              p[static_cast<std::size_t>(i)] += by;
              return station_residual(c.station, p, kind, sizes);
            },
            h);
        CAPTURE(parameter(i).name, trial);
        CHECK((m.by_parameter.col(i) - d).norm() * h < 1e-7 * (1 + d.norm() * h));
      }
      for (int axis = 0; axis < 3; ++axis) {
        const auto moved = [&](double g, double b) {
          StationReadings s = c.station;
          (axis == 0 ? s.gravity_T.x : axis == 1 ? s.gravity_T.y : s.gravity_T.z) += g;
          (axis == 0 ? s.magnetic_T.x : axis == 1 ? s.magnetic_T.y : s.magnetic_T.z) += b;
          return station_residual(s, at, kind, sizes);
        };
        const Vector3d dg = difference([&](double by) { return moved(by, 0); }, 0.01),
                       db = difference([&](double by) { return moved(0, by); }, 50);
        CHECK((m.by_gravity.col(axis) - dg).norm() * 0.01 < 1e-7 * (1 + dg.norm() * 0.01));
        CHECK((m.by_magnetic.col(axis) - db).norm() * 50 < 1e-7 * (1 + db.norm() * 50));
      }
      CHECK(m.by_reference.isApprox(-Eigen::Matrix3d(Vector3d(1 / sizes[0], 1 / sizes[1], 1 / sizes[2]).asDiagonal())));
    }
}

TEST_CASE("A rotation of the magnetometers leaves the total field alone, and equal scales of all axes the dip") {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    Case c = random_case(random, ResidualKind::calibration);
    c.tool = {};  // a triad with errors turns a rotation into a little more than one
    const StationModel m = station_model(c.station, c.tool, ResidualKind::calibration, {1, 1, 1});
    for (int i = 0; i < 3; ++i) CHECK(std::abs(m.by_parameter(1, kRotation + i)) < 1e-9);
    const Vector3d scales = m.by_parameter.middleCols<3>(kMagnetometerScale).rowwise().sum();
    CHECK(scales[1] == Approx(-m.field_T.norm()).epsilon(1e-12));
    CHECK(std::abs(scales[2]) < 1e-12);
  }
}
