#include "survey/frames.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "thesis_cases.h"

using namespace surveymc;
using namespace surveymc::survey;

TEST_CASE("The conventions' reference attitude has its documented vectors") {
  // docs/conventions.md: I 35, T 57 (from x), A 123, G 1, Bh 12940.952, Bv 48296.291.
  const double bh = 12940.952, bv = 48296.291;
  const Attitude at{35 * kDegree, 123 * kDegree, (57 + 90) * kDegree};
  const Vec3<double> b = magnetic_T(at, std::hypot(bh, bv), std::atan2(bv, bh)), g = down_T(at);
  CHECK(std::abs(b.x - -27334.1122) < 1e-3);  // the inputs have 8 digits
  CHECK(std::abs(b.y - 22163.5231) < 1e-3);
  CHECK(std::abs(b.z - 35519.3541) < 1e-3);
  CHECK(std::abs(g.x - -.312392) < 1e-6);
  CHECK(std::abs(g.y - .481042) < 1e-6);
  CHECK(std::abs(g.z - .819152) < 1e-6);
}

TEST_CASE("The tool sees gravity and field at their true angle and strength, whatever the attitude") {
  const double total = 51000, dip = 72 * kDegree;
  for (const Attitude& at : test::difficult_attitudes()) {
    const Vec3<double> u = down_T(at), b = magnetic_T(at, total, dip);
    CAPTURE(at.inclination, at.azimuth, at.toolface);
    CHECK(std::abs(norm(u) - 1) < 4e-16);
    CHECK(std::abs(norm(b) - total) < 1e-10);  // 2e-15 of the field
    CHECK(std::abs(dot(u, b) - total * std::sin(dip)) < 5e-11);
  }
}

TEST_CASE("The direction of the hole comes back from the fields, singular nowhere") {
  for (const double dip : {-60.0, 0.0, 72.0, 88.0})
    for (const Attitude& at : test::difficult_attitudes()) {
      const Vec3<double> t = tangent_from_fields(down_T(at), magnetic_T(at, 51000, dip * kDegree)),
                         exact = tangent_N(at);
      CAPTURE(dip, at.inclination, at.azimuth, at.toolface);
      const double bound = 5e-15 / std::cos(dip * kDegree);  // rounding of b, over the horizontal part it must resolve
      CHECK(std::abs(t.x - exact.x) < bound);
      CHECK(std::abs(t.y - exact.y) < bound);
      CHECK(std::abs(t.z - exact.z) < bound);
    }
}

TEST_CASE("Attitude comes back from the fields in every quadrant") {
  for (const Attitude& at : test::difficult_attitudes()) {
    const Vec3<double> g = scale(9.8, down_T(at)), b = magnetic_T(at, 50000, 60 * kDegree);
    const Attitude back = attitude_from_fields(g, b);
    CAPTURE(at.inclination, at.azimuth, at.toolface);
    CHECK(std::abs(back.inclination - at.inclination) < 2e-15 + 1e-15);
    CHECK(back.azimuth >= 0);
    CHECK(back.azimuth < 2 * kPi + 1e-15);
    // In or near the vertical only a combination of azimuth and toolface exists: compare what the tool sees.
    const Vec3<double> b2 = magnetic_T(back, 50000, 60 * kDegree), u2 = down_T(back);
    CHECK(norm(b2 - b) < 50000 * 2e-14);
    CHECK(norm(u2 - down_T(at)) < 1e-14);
  }
}

TEST_CASE("Toolface measured from x is toolface from y plus 90 degrees: the thesis' own forms") {
  for (const Attitude& at : test::difficult_attitudes()) {
    const double t = at.toolface, i = at.inclination;  // thesis: Gx = -g cosT sinI, Gy = g sinT sinI
    const Vec3<double> u = down_T({i, at.azimuth, t + kPi / 2});
    CHECK(std::abs(u.x - -std::cos(t) * std::sin(i)) < 1e-15);
    CHECK(std::abs(u.y - std::sin(t) * std::sin(i)) < 1e-15);
  }
}

TEST_CASE("HLA rotation is orthonormal and its third row is the hole") {
  for (const Attitude& at : test::difficult_attitudes()) {
    const Eigen::Matrix3d r = rotation_hla_from_nev(at.inclination, at.azimuth);
    CHECK((r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 4e-16);
    CHECK((r.row(2).transpose() - to_eigen(tangent_N(at))).norm() < 1e-15);
    CHECK(r.determinant() == Approx(1).epsilon(1e-15));
    CHECK(r(1, 2) == 0);  // lateral is horizontal
  }
}

TEST_CASE("Declination turns magnetic into true north, clockwise") {
  const double declination = 12 * kDegree;
  const Vec3<double> magnetic = tangent_N({40 * kDegree, 100 * kDegree, 0});
  const Vec3<double> t = magnetic_to_true(magnetic, std::sin(declination), std::cos(declination));
  const Vec3<double> exact = tangent_N({40 * kDegree, 112 * kDegree, 0});
  CHECK(norm(t - exact) < 1e-15);
}
