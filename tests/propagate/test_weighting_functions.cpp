#include "propagate/weighting_functions.h"

#include <functional>
#include <map>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "propagate/iscwsa_covariance.h"
#include "propagate/station_effects.h"
#include "survey/minimum_curvature.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::propagate;
using Eigen::Vector3d;

namespace {

constexpr double kDeclination = -4 * kDegree;

survey::ReferenceField field_of(double dip_deg) {
  survey::ReferenceField f;
  f.total = 50000;
  f.dip = dip_deg * kDegree;
  f.declination = kDeclination;
  return f;
}

/// Two stations `dmd` apart, both at `at`.
StationGeometry geometry(const survey::Attitude& at, const survey::ReferenceField& field, double md = 1000,
                         double dmd = 30) {
  survey::Survey s;
  s.stations = {{md - dmd, at.inclination, at.azimuth, 0}, {md, at.inclination, at.azimuth, 0}};
  return station_geometry(s, {md - dmd, 800}, field, 1);
}

/// The tables of ISCWSA: weights of depth, inclination and azimuth, with 1/sinI where they have it.
struct Published {
  double depth, inclination, azimuth;
};
std::map<std::string, Published> published(const survey::Attitude& at, const survey::ReferenceField& f, double md,
                                           double tvd) {
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

Weights weights(const std::string& name, const StationGeometry& s) { return find_weighting_function(name)->weights(s); }

/// Effect on the hole's direction (true north): inclination and lateral weight along their unit vectors.
Vector3d turn(const Weights& w, const survey::Attitude& at) {
  return w.inclination * survey::tangent_by_inclination(at.inclination, at.azimuth) +
         w.lateral * Vector3d(-std::sin(at.azimuth), std::cos(at.azimuth), 0);
}

}  // namespace

TEST_CASE("Weights are the published ones, with sinI taken into those of azimuth") {
  std::size_t compared = 0;
  for (const double dip : {72.0, -58.0, 0.0})
    for (const survey::Attitude& at : test::difficult_attitudes()) {
      if (std::abs(std::sin(at.inclination)) < 1e-6 || at.toolface != 0) continue;  // theirs are singular there
      const survey::ReferenceField field = field_of(dip);
      for (const auto& [name, p] : published(at, field, 1000, 800)) {
        CAPTURE(name, dip, at.inclination, at.azimuth);
        REQUIRE(find_weighting_function(name));
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
    for (const survey::Attitude& at : test::difficult_attitudes()) {
      const survey::ReferenceField field = field_of(dip);
      const survey::Attitude magnetic{at.inclination, at.azimuth - field.declination, at.toolface};
      const survey::StationFields s{survey::magnetic_T(magnetic, field.total, field.dip), survey::down_T(magnetic)};
      const TangentDerivatives by = tangent_derivatives(s);
      const Vector3d u = survey::to_eigen(s.down_T), z = Vector3d::UnitZ();
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
  const survey::ReferenceField field = field_of(72);
  for (const double azimuth : {0.0, 33.0, 180.0, 359.0})
    for (const WeightingFunction& f : weighting_functions()) {
      const survey::Attitude vertical{0, azimuth * kDegree, 0};
      const Vector3d limit = turn(f.weights(geometry(vertical, field)), vertical);
      CAPTURE(f.name, azimuth);
      REQUIRE(limit.allFinite());
      if (std::string(f.name) == "SAGE") continue;  // its fourth root of sinI is steep: .0056 at 1e-9 rad
      for (const double inclination : {1e-12, 1e-9, 1e-6}) {
        const survey::Attitude at{inclination, azimuth * kDegree, 0};
        // Slopes are at most 1 + tanD; the course terms have metres per radian of 30 m.
        CHECK((turn(f.weights(geometry(at, field)), at) - limit).norm() <= 30 * 5 * inclination);
      }
    }
  // The published vertical branch of XYM3, XYM4 (north, east) and ABXY-TI2 (across the azimuth).
  for (const double azimuth : {0.0, 75.0, 200.0}) {
    const survey::Attitude at{0, azimuth * kDegree, 0};
    const StationGeometry g = geometry(at, field);
    CHECK((turn(weights("XYM3", g), at) - Vector3d(1, 0, 0)).norm() < 3e-16);
    CHECK((turn(weights("XYM4", g), at) - Vector3d(0, 1, 0)).norm() < 3e-16);
    CHECK((turn(weights("ABXY-TI2", g), at) - Vector3d(-std::sin(at.azimuth), std::cos(at.azimuth), 0) / field.gravity)
              .norm() < 3e-17);
  }
}

TEST_CASE("Misalignment of close stations is larger: sqrt(10 m / leg) below 10 m") {
  const survey::ReferenceField field = field_of(72);
  const survey::Attitude at{0.7, 1.1, 0};
  for (const auto& [dmd, factor] : {std::pair{30.0, 1.0}, {10.0, 1.0}, {2.5, 2.0}, {0.1, 10.0}}) {
    for (const auto& [plain, scaled] : {std::pair{"XYM3", "XYM3E"}, {"XYM4", "XYM4E"}}) {
      const StationGeometry g = geometry(at, field, dmd, dmd);  // from depth 0: exact
      CHECK(weights(scaled, g).inclination == Approx(factor * weights(plain, g).inclination).epsilon(1e-13));
      CHECK(weights(scaled, g).lateral == Approx(factor * weights(plain, g).lateral).epsilon(1e-13));
    }
  }
}

TEST_CASE("Course errors grow with the turn between stations, and have a least tortuosity of 1 deg / 100 ft") {
  CHECK(kLeastTortuosity == Approx(5.72614584e-4).epsilon(1e-8));
  const survey::ReferenceField field = field_of(72);
  const auto course = [&](const survey::Station& from, const survey::Station& to) {
    survey::Survey s;
    s.stations = {from, to};
    const StationGeometry g = station_geometry(s, {0, 0}, field, 1);
    return std::pair{weights("XCLA", g).lateral, weights("XCLH", g).inclination};
  };
  const double d = 30, floor = d * d * kLeastTortuosity;
  const auto straight = course({0, 0.5, 1, 0}, {d, 0.5, 1, 0});
  CHECK(straight.first == Approx(floor).epsilon(1e-14));
  CHECK(straight.second == Approx(floor).epsilon(1e-14));
  const auto turned = course({0, 0.5, 1.0, 0}, {d, 0.6, 1.4, 0});
  CHECK(turned.first == Approx(d * std::sin(0.6) * std::sin(0.4)).epsilon(1e-14));
  CHECK(turned.second == Approx(d * 0.1).epsilon(1e-13));
  // Through north the turn is that of the angle, not of the numbers.
  const auto through = course({0, 0.5, 2 * kPi - 0.2, 0}, {d, 0.6, 0.2, 0});
  CHECK(through.first == Approx(turned.first).epsilon(1e-13));
  // A vertical station has no azimuth to turn from, whatever is listed.
  for (const double inclination : {0.0, 1e-9, 1e-6})
    for (const double azimuth : {0.0, 2.0, 5.0})
      CHECK(course({0, inclination, azimuth, 0}, {d, 0.035, 1, 0}).first == Approx(floor).epsilon(1e-14));
}

TEST_CASE("Functions are found by name, once each") {
  std::map<std::string, int> count;
  for (const WeightingFunction& f : weighting_functions()) ++count[f.name];
  for (const auto& [name, times] : count) {
    CHECK(times == 1);
    CHECK(find_weighting_function(name)->name == name);
  }
  CHECK(find_weighting_function("ABXY") == nullptr);
  CHECK(find_weighting_function("") == nullptr);
}
