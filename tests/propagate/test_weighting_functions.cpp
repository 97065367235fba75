/// The shipped weighting functions against the tables of ISCWSA and what a tool reads.
#include <map>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "angles.h"
#include "base/units.h"
#include "config/shipped_models.h"
#include "error_model/model_graph.h"
#include "propagate/station_effects.h"
#include "propagate/tool_covariance.h"
#include "propagate/tool_weights.h"
#include "propagate/toolface_independent.h"
#include "survey/minimum_curvature.h"
#include "thesis_cases.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::config;
using namespace surveymc::propagate;
using namespace surveymc::survey;
using Eigen::Vector3d;

namespace {

ReferenceField field_of(double dip_deg) { return test::field_of(50000, dip_deg, -4); }

/// Two stations, and what is round them.
struct StationGeometry {
  error_model::SampleStation station;
  error_model::Surroundings surroundings;
};
StationGeometry geometry_of(const Station& from, const Station& to, const ReferenceField& field) {
  return {.station = {.inclination = to.inclination,
                      .azimuth = to.azimuth,
                      .declination = field.declination,
                      .md = to.md,
                      .dmd = to.md - from.md,
                      .tvd = 800,
                      .inclination_before = from.inclination,
                      .azimuth_before = azimuth_before(from, to)},
          .surroundings = error_model::surroundings_of({}, field.dip, field.total, field.gravity, 1)};
}
/// Two stations `dmd` apart, both at `at`.
StationGeometry geometry(const Attitude& at, const ReferenceField& field, double md = 1000, double dmd = 30) {
  return geometry_of({md - dmd, at.inclination, at.azimuth, 0}, {md, at.inclination, at.azimuth, 0}, field);
}

using error_model::Weights;
Weights weights(const error_model::Function& f, const StationGeometry& g) {
  return error_model::weights_at(f, g.station, g.surroundings);
}
Weights weights(const std::string& name, const StationGeometry& g) { return weights(*shipped_functions().at(name), g); }

/// The tables of ISCWSA: weights of depth, inclination and azimuth, with 1/sinI where they have it.
struct Published {
  double depth, inclination, azimuth;
};
std::map<std::string, Published> published(const Attitude& at, const ReferenceField& f, double md, double tvd) {
  const double I = at.inclination, A = at.azimuth, Am = A - f.declination, G = f.gravity, B = f.total, D = f.dip;
  using std::abs, std::cos, std::sin, std::sqrt, std::tan;
  const double Bh = B * cos(D);
  return {
      {"DREF", {1, 0, 0}},
      {"DSF", {md, 0, 0}},
      {"DST", {md * tvd, 0, 0}},
      {"ABXY-TI1", {0, -cos(I) / G, tan(D) * cos(I) * sin(Am) / G}},
      {"ABXY-TI2", {0, 0, (cos(I) / sin(I) - tan(D) * cos(Am)) / G}},
      {"ABZ", {0, -sin(I) / G, tan(D) * sin(I) * sin(Am) / G}},
      {"ASXY-TI1", {0, sin(I) * cos(I) / sqrt(2), -tan(D) * sin(I) * cos(I) * sin(Am) / sqrt(2)}},
      {"ASXY-TI2", {0, sin(I) * cos(I) / 2, -tan(D) * sin(I) * cos(I) * sin(Am) / 2}},
      {"ASXY-TI3", {0, 0, (tan(D) * sin(I) * cos(Am) - cos(I)) / 2}},
      {"ASZ", {0, -sin(I) * cos(I), tan(D) * sin(I) * cos(I) * sin(Am)}},
      {"MBXY-TI1", {0, 0, -cos(I) * sin(Am) / Bh}},
      {"MBXY-TI2", {0, 0, cos(Am) / Bh}},
      {"MBZ", {0, 0, -sin(I) * sin(Am) / Bh}},
      {"MSXY-TI1", {0, 0, sin(I) * sin(Am) * (tan(D) * cos(I) + sin(I) * cos(Am)) / sqrt(2)}},
      {"MSXY-TI2", {0, 0, sin(Am) * (tan(D) * sin(I) * cos(I) - cos(I) * cos(I) * cos(Am) - cos(Am)) / 2}},
      {"MSXY-TI3", {0, 0, (cos(I) * cos(Am) * cos(Am) - cos(I) * sin(Am) * sin(Am) - tan(D) * sin(I) * cos(Am)) / 2}},
      {"MSZ", {0, 0, -(sin(I) * cos(Am) + tan(D) * cos(I)) * sin(I) * sin(Am)}},
      {"AZ", {0, 0, 1}},
      {"DBH", {0, 0, 1 / Bh}},
      {"AMIL", {0, 0, sin(I) * sin(Am) / Bh}},
      {"SAG", {0, sin(I), 0}},
      {"SAGE", {0, std::pow(abs(sin(I)), 0.25), 0}},
      {"XYM1", {0, abs(sin(I)), 0}},
      {"XYM2", {0, 0, -1}},
      {"XYM3", {0, abs(cos(I)) * cos(A), -abs(cos(I)) * sin(A) / sin(I)}},
      {"XYM4", {0, abs(cos(I)) * sin(A), abs(cos(I)) * cos(A) / sin(I)}},
  };
}

/// Effect on the hole's direction (true north): inclination and lateral weight along their unit vectors.
Vector3d turn(const Weights& w, const Attitude& at) {
  return w.inclination * test::tangent_by_inclination(at.inclination, at.azimuth) +
         w.lateral * Vector3d(-std::sin(at.azimuth), std::cos(at.azimuth), 0);
}

}  // namespace

TEST_CASE("Weights are the published ones, with sinI taken into those of azimuth") {
  std::size_t compared = 0;
  for (const double dip : {72.0, -58.0, 0.0})
    for (const Attitude& at : test::difficult_attitudes()) {
      if (std::abs(std::sin(at.inclination)) < 1e-6 || at.toolface != 0) continue;  // theirs are singular there
      const ReferenceField field = field_of(dip);
      for (const auto& [name, p] : published(at, field, 1000, 800)) {
        CAPTURE(name, dip, at.inclination, at.azimuth);
        const Weights w = weights(name, geometry(at, field));
        const double lateral = std::sin(at.inclination) * p.azimuth;
        CHECK(w.depth == p.depth);
        CHECK(std::abs(w.inclination - p.inclination) <= 1e-15 * (1 + std::abs(p.inclination)));
        // The published terms cancel to a part of tanD and cotI, which is at most 4 with these dips.
        CHECK(std::abs(w.lateral - lateral) <= 4e-15 * (1 + std::abs(lateral)));
        ++compared;
      }
    }
  CHECK(compared > 3 * 26 * 50);
}

TEST_CASE("The weights of axial sensor errors follow from what the tool reads") {
  // No toolface enters an error along the tool's axis, so the tool's readings themselves are the oracle.
  for (const double dip : {72.0, -58.0})
    for (const Attitude& at : test::difficult_attitudes()) {
      const ReferenceField field = field_of(dip);
      const Attitude magnetic{at.inclination, at.azimuth - field.declination, at.toolface};
      const StationFields s{magnetic_T(magnetic, field.total, field.dip), down_T(magnetic)};
      const TangentDerivatives by = tangent_derivatives(s);
      const Vector3d u = to_eigen(s.down_T), z = Vector3d::UnitZ();
      const Vector3d du = (z - u.z() * u) / field.gravity;  // of the direction, by the axial accelerometer
      Eigen::Matrix3d to_true = Eigen::Matrix3d::Identity();
      to_true.topLeftCorner<2, 2>() << std::cos(field.declination), -std::sin(field.declination),
          std::sin(field.declination), std::cos(field.declination);
      const StationGeometry g = geometry(at, field);
      const double gz = field.gravity * u.z(), bz = s.field_T.z;
      CAPTURE(dip, at.inclination, at.azimuth, at.toolface);
      const auto close = [&](const char* name, const Vector3d& expected) {
        CAPTURE(name);
        CHECK((turn(weights(name, g), at) - expected).norm() <= 1e-14 * (1 + expected.norm()));
      };
      close("ABZ", to_true * by.by_down * du);
      close("ASZ", to_true * by.by_down * du * gz);
      close("MBZ", to_true * by.by_field * z);
      close("MSZ", to_true * by.by_field * z * bz);
    }
}

TEST_CASE("Nothing is singular in a vertical hole, and weights are continuous there") {
  const ReferenceField field = field_of(72);
  for (const double azimuth : {0.0, 33.0, 180.0, 359.0})
    for (const auto& [name, shipped] : shipped_functions()) {
      const error_model::Function& f = *shipped;
      if (f.kind == error_model::Kind::continuous) continue;
      const Attitude vertical{0, azimuth * kDegree, 0};
      const Vector3d limit = turn(weights(f, geometry(vertical, field)), vertical);
      CAPTURE(name, azimuth);
      REQUIRE(limit.allFinite());
      if (name == "SAGE") continue;  // its fourth root of sinI is steep: 0.0056 at 1e-9 rad
      for (const double inclination : {1e-12, 1e-9, 1e-6}) {
        const Attitude at{inclination, azimuth * kDegree, 0};
        // Slopes are at most 1 + tanD per unit; a gyro's are over the earth's rate, 1 / (7.3e-5 rad/s cos 57 deg).
        const double scale = f.kind == error_model::Kind::stationary ? 1e5 : 150;
        CHECK((turn(weights(f, geometry(at, field)), at) - limit).norm() <= scale * inclination);
      }
    }
  // The published vertical branch of XYM3, XYM4 (north, east) and ABXY-TI2 (across the azimuth).
  for (const double azimuth : {0.0, 75.0, 200.0}) {
    const Attitude at{0, azimuth * kDegree, 0};
    const StationGeometry g = geometry(at, field);
    CHECK((turn(weights("XYM3", g), at) - Vector3d(1, 0, 0)).norm() < 3e-16);
    CHECK((turn(weights("XYM4", g), at) - Vector3d(0, 1, 0)).norm() < 3e-16);
    CHECK((turn(weights("ABXY-TI2", g), at) - Vector3d(-std::sin(at.azimuth), std::cos(at.azimuth), 0) / field.gravity)
              .norm() < 3e-17);
  }
}

TEST_CASE("Misalignment of close stations is larger: sqrt(10 m / leg) below 10 m") {
  const ReferenceField field = field_of(72);
  const Attitude at{0.7, 1.1, 0};
  for (const auto& [dmd, factor] : {std::pair{30.0, 1.0}, {10.0, 1.0}, {2.5, 2.0}, {0.1, 10.0}}) {
    for (const auto& [plain, scaled] : {std::pair{"XYM3", "XYM3E"}, {"XYM4", "XYM4E"}}) {
      const StationGeometry g = geometry(at, field, dmd, dmd);  // from depth 0: exact
      CHECK(weights(scaled, g).inclination == Approx(factor * weights(plain, g).inclination).epsilon(1e-13));
      CHECK(weights(scaled, g).lateral == Approx(factor * weights(plain, g).lateral).epsilon(1e-13));
    }
  }
}

TEST_CASE("Course errors grow with the turn between stations, and have a least tortuosity of 1 deg / 100 ft") {
  const double least = error_model::Parameters().tortuosity;
  CHECK(least == Approx(5.72614584e-4).epsilon(1e-8));
  const ReferenceField field = field_of(72);
  /// Over metres of the course.
  const auto course = [&](const Station& from, const Station& to) {
    StationGeometry g = geometry_of(from, to, field);
    g.surroundings.tortuosity = least;
    return std::pair{weights("XCLA", g).lateral, weights("XCLH", g).inclination};
  };
  const double d = 30, floor = d * least;
  const auto straight = course({0, 0.5, 1, 0}, {d, 0.5, 1, 0});
  CHECK(straight.first == Approx(floor).epsilon(1e-14));
  CHECK(straight.second == Approx(floor).epsilon(1e-14));
  const auto turned = course({0, 0.5, 1.0, 0}, {d, 0.6, 1.4, 0});
  CHECK(turned.first == Approx(std::sin(0.6) * std::sin(0.4)).epsilon(1e-14));
  CHECK(turned.second == Approx(0.1).epsilon(1e-13));
  // Through north the turn is that of the angle, not of the numbers.
  const auto through = course({0, 0.5, 2 * kPi - 0.2, 0}, {d, 0.6, 0.2, 0});
  CHECK(through.first == Approx(turned.first).epsilon(1e-13));
  // A vertical station has no azimuth to turn from, whatever is listed.
  for (const double inclination : {0.0, 1e-9, 1e-6})
    for (const double azimuth : {0.0, 2.0, 5.0})
      CHECK(course({0, inclination, azimuth, 0}, {d, 0.035, 1, 0}).first == Approx(floor).epsilon(1e-14));
}

TEST_CASE("The closed forms of the toolface-independent terms are the shipped formulas") {
  for (const double dip : {72.0, -58.0})
    for (const Attitude& at : test::difficult_attitudes()) {
      const ReferenceField field = field_of(dip);
      const StationGeometry g = geometry({at.inclination, at.azimuth, 0}, field);
      for (const ToolfaceIndependentTerm& t :
           toolface_independent_terms(at.inclination, at.azimuth - field.declination, field)) {
        const Weights w = weights(t.code, g);
        CAPTURE(t.code, at.inclination, at.azimuth);
        CHECK(std::abs(w.inclination - t.inclination) <= 1e-15 * (1 + std::abs(w.inclination)));
        CHECK(std::abs(w.lateral - t.lateral) <= 4e-15 * (1 + std::abs(w.lateral)));
      }
    }
}
