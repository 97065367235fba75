#include "earth/geodesy.h"

#include <catch2/catch.hpp>

#include "base/units.h"

using namespace surveymc;
using namespace surveymc::earth;
using Catch::Matchers::WithinAbs;

namespace {
Place degrees(double latitude, double longitude, double height = 0) {
  return {latitude * kDegree, longitude * kDegree, height};
}
}  // namespace

TEST_CASE("Normal gravity is that of WGS84 at the equator and the poles, and falls with height") {
  // NIMA TR8350.2, table 3.4: 9.7803253359 and 9.8321849378 m/s2.
  CHECK_THAT(normal_gravity(degrees(0, 20)), WithinAbs(9.7803253359, 1e-10));
  CHECK_THAT(normal_gravity(degrees(90, 0)), WithinAbs(9.8321849378, 1e-10));
  CHECK_THAT(normal_gravity(degrees(-90, 0)), WithinAbs(9.8321849378, 1e-10));
  // Second-order height formula of the same report, equation 4-3: terms of third order, g (h/a)^3, stay below 1e-5 g at
  // 100 km.
  const double a = 6378137, f = 1 / 298.257223563, m = 0.00344978650684, latitude = 60 * kDegree, h = 100e3;
  const double s2 = std::sin(latitude) * std::sin(latitude), ground = normal_gravity(degrees(60, 5));
  const double expected = ground * (1 - 2 / a * (1 + f + m - 2 * f * s2) * h + 3 * h * h / (a * a));
  CHECK_THAT(normal_gravity(degrees(60, 5, h)), WithinAbs(expected, 1e-5 * ground * 4));
}

TEST_CASE("UTM zones have the exceptions of Norway and Svalbard, and end at 80 S and 84 N") {
  CHECK(utm_zone(degrees(60.5, 2.5)) == 31);
  CHECK(utm_zone(degrees(60.4, 5.3)) == 32);   // Bergen: would be 31
  CHECK(utm_zone(degrees(78.2, 15.6)) == 33);  // Longyearbyen
  CHECK(utm_zone(degrees(-20, 179.9)) == 60);
  CHECK(utm_zone(degrees(-20, -180)) == 1);
  CHECK(has_utm(degrees(-80, 0)));
  CHECK(has_utm(degrees(84, 0)));
  CHECK_FALSE(has_utm(degrees(-80.1, 0)));
  CHECK_FALSE(has_utm(degrees(84.1, 0)));
  CHECK_THAT(distance_from_central_meridian(degrees(0, 179), 1) / kDegree, WithinAbs(4, 1e-12));
}

TEST_CASE("Convergence is zero on the central meridian, positive to its east in the north, and odd") {
  CHECK_THAT(utm_convergence(degrees(60, 3), 31), WithinAbs(0, 1e-15));
  const double east = utm_convergence(degrees(60, 5), 31);
  CHECK_THAT(utm_convergence(degrees(60, 1), 31), WithinAbs(-east, 1e-14));
  CHECK_THAT(utm_convergence(degrees(-60, 5), 31), WithinAbs(-east, 1e-14));
  CHECK(east > 0);
  // tan c = tan dl sin phi on a sphere; the ellipsoid adds e'^2 cos^4(phi) sin(phi) dl^3 and less: 3e-7 rad here.
  const double sphere = std::atan(std::tan(2 * kDegree) * std::sin(60 * kDegree));
  CHECK_THAT(east, WithinAbs(sphere, 3e-7));
}
