#include "propagate/hole_direction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "survey/minimum_curvature.h"

using namespace surveymc;
using propagate::hole_direction;

namespace {

survey::Station station(double md, double inclination, double azimuth) {
  return {md, inclination * kDegree, azimuth * kDegree, 0};
}
Eigen::Vector3d tangent(double inclination, double azimuth) {
  return survey::to_eigen(survey::tangent_N({inclination, azimuth, 0}));
}

}  // namespace

TEST_CASE("Between vertical stations the azimuth of the hole is the listed one, which says where high side is") {
  for (const double inclination : {0.0, 0.00005, 180.0}) {
    const survey::Station from = station(1500, inclination, 75), to = station(1800, inclination, 75);
    for (const double share : {0.0, 0.25, 0.5, 0.999, 1.0}) {
      const propagate::HoleDirection d = hole_direction(from, to, share);
      CHECK(d.azimuth == 75 * kDegree);
      CHECK(std::abs(d.inclination - inclination * kDegree) < 1e-15);
    }
  }
  // A hole that turns over: vertical between its stations, in the middle of the arc.
  CHECK(hole_direction(station(0, 30, 20), station(100, 30, 200), 0.5).azimuth == 20 * kDegree);
}

TEST_CASE("The hole turns along the arc at a constant rate, and is as listed at its stations") {
  for (const auto& [from, to] :
       {std::pair{station(300, 0, 0), station(400, 60, 0)}, std::pair{station(400, 60, 0), station(500, 90, 90)},
        std::pair{station(0, 45, 350), station(100, 45, 350)},
        std::pair{station(0, 45, 350), station(100, 45 + 1e-9, 350)},
        std::pair{station(0, 10, 0), station(100, 160, 30)}}) {
    const Eigen::Vector3d t0 = tangent(from.inclination, from.azimuth), t1 = tangent(to.inclination, to.azimuth);
    const double dogleg = std::acos(std::min(1.0, t0.dot(t1)));
    CHECK(hole_direction(from, to, 0).azimuth == from.azimuth);
    CHECK(hole_direction(from, to, 1).inclination == to.inclination);
    for (const double share : {0.25, 0.5, 0.9}) {
      const propagate::HoleDirection d = hole_direction(from, to, share);
      const Eigen::Vector3d t = tangent(d.inclination, d.azimuth);
      // acos loses half of the digits for small angles.
      CHECK(std::abs(std::acos(std::min(1.0, t.dot(t0))) - share * dogleg) < 3e-8);
      CHECK(std::abs(std::acos(std::min(1.0, t.dot(t1))) - (1 - share) * dogleg) < 3e-8);
      CHECK(std::abs(t.dot(t0.cross(t1))) < 1e-15);
    }
  }
}
