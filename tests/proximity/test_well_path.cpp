#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "proximity/well_path.h"
#include "tools.h"

using namespace surveymc;
using namespace surveymc::proximity;
using Eigen::Vector3d;
using surveymc::test::survey_of;

namespace {

/// Legs of 5 to 60 m with doglegs up to 150 deg, vertical, straight and nearly straight ones among them.
survey::Survey wild_well(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<std::array<double, 3>> stations{{100, 0, 30}};
  for (int k = 0; k < 12; ++k) {
    auto next = stations.back();
    next[0] += 5 + 55 * unit(random);
    if (k % 4 == 1) next[1] += 1e-9;
    if (k % 4 == 2) next[1] = 30 * unit(random);
    if (k % 4 == 3) next = {next[0], 110 * unit(random), 360 * unit(random)};
    stations.push_back(next);
  }
  return survey_of(stations);
}

/// What a search in small steps finds: the least distance, and how often the distance turns from falling to rising.
struct Search {
  double least = HUGE_VAL;
  int minima = 0;
};
Search search(const WellPath& path, const Vector3d& q, double step) {
  Search s;
  double before = HUGE_VAL, second = HUGE_VAL;
  const double first = path.md(0), last = path.md(path.stations() - 1);
  const int steps = static_cast<int>((last - first) / step);
  for (int i = 0; i <= steps; ++i) {
    const double d = (path.at(first + (last - first) * i / steps).position - q).norm();
    if (d >= before && before < second) ++s.minima;
    s.least = std::min(s.least, d);
    second = before;
    before = d;
  }
  if (before < second) ++s.minima;
  return s;
}

}  // namespace

TEST_CASE("A path goes through its stations along their directions, and is as long as its measured depth") {
  const survey::Survey s = wild_well(1);
  const WellPath path = well_path(s, {10, -20, 30});
  for (std::size_t k = 0; k < path.stations(); ++k) {
    const PathPoint at = path.at(s.stations[k].md), station = path.at_station(k);
    CHECK((at.position - station.position).norm() < 1e-10);
    CHECK((at.tangent - station.tangent).norm() < 1e-12);
    CHECK(at.md == s.stations[k].md);
  }
  CHECK(path.at_station(0).position == Vector3d(10, -20, 30));
  // From both sides of every station, and the length of a polygon: an arc is at most its angle^2 / 24 longer than
  // chords.
  double length = 0;
  constexpr int kSteps = 20000;
  const double first = path.md(0), all = path.md(path.stations() - 1) - first;
  for (int i = 0; i < kSteps; ++i)
    length += (path.at(first + all * (i + 1) / kSteps).position - path.at(first + all * i / kSteps).position).norm();
  CHECK(length <= all * (1 + 1e-12));
  CHECK(length > all * (1 - 1e-6));
  for (std::size_t k = 1; k + 1 < path.stations(); ++k)
    CHECK((path.at(path.md(k) - 1e-7).position - path.at(path.md(k) + 1e-7).position).norm() < 2.1e-7);
}

TEST_CASE("The closest point is the one that a search in steps of a centimetre finds", "[long]") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, 120);
  std::vector<ClosestPoint> minima;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const WellPath path = well_path(wild_well(seed), Vector3d::Zero());
    for (int i = 0; i < 12; ++i) {
      const Vector3d q(normal(random), normal(random), 150 + normal(random));
      const ClosestPoint c = path.closest(q, 0);
      const Search s = search(path, q, 0.01);
      CAPTURE(seed, i, c.point.md);
      // The distance changes by less than the depth does: half a step from the minimum at most.
      CHECK(c.distance <= s.least + 1e-9);
      CHECK(c.distance > s.least - 0.005);
      CHECK((path.at(c.point.md).position - q).norm() == Approx(c.distance).epsilon(1e-9));
      path.local_minima(q, 0, minima);
      CHECK(static_cast<int>(minima.size()) == s.minima);
      for (const ClosestPoint& m : minima) {
        CHECK(m.distance >= c.distance);
        const double slope = (m.point.position - q).dot(m.point.tangent);
        if (m.end == PathEnd::interior) CHECK(std::abs(slope) < 1e-6 * (1 + m.distance));
        if (m.end == PathEnd::start) CHECK(slope >= 0);
        if (m.end == PathEnd::end) CHECK(slope < 0);
      }
    }
  }
}

TEST_CASE("On a quarter circle the closest point lies on the ray from the centre") {
  // From down to north, radius 200: the centre is 200 m north of the beginning.
  const double r = 200;
  const WellPath path = well_path(survey_of({{0, 0, 0}, {r * kPi / 2, 90, 0}}), Vector3d::Zero());
  for (const double turned : {0.0, 1e-7, 0.3, 1.0, kPi / 2}) {
    const Vector3d ray(-std::cos(turned), 0, std::sin(turned)), centre(r, 0, 0);
    for (const double distance : {1e-3, 50.0, 200.0, 500.0}) {
      const ClosestPoint c = path.closest(centre + distance * ray + Vector3d(0, 40, 0), 0);
      CHECK(c.point.md == Approx(r * turned).margin(1e-9).epsilon(1e-12));
      CHECK(c.distance == Approx(std::hypot(distance - r, 40)).epsilon(1e-12));
    }
  }
  // From the axis every point is as near: the shallowest counts.
  CHECK(path.closest({r, 70, 0}, 0).distance == Approx(std::hypot(r, 70)).epsilon(1e-14));
  CHECK(path.closest({r, 70, 0}, 0).point.md == Approx(0).margin(1e-9));
}

TEST_CASE("Beside a straight hole the closest point is at the same depth; beyond its ends it is the end") {
  const WellPath path = well_path(survey_of({{0, 0, 0}, {30, 0, 0}, {60, 0, 0}, {90, 0, 0}}), {0, 100, 0});
  for (const double md : {0.0, 12.5, 30.0, 60.0, 77.0, 90.0}) {
    const ClosestPoint c = path.closest({0, 0, md}, 0);
    CHECK(c.point.md == Approx(md).margin(1e-12));
    CHECK(c.distance == 100);
  }
  CHECK(path.closest({0, 0, -1}, 0).end == PathEnd::start);
  CHECK(path.closest({0, 0, 91}, 0).end == PathEnd::end);
  CHECK(path.closest({0, 0, 91}, 0).distance == Approx(std::hypot(100, 1)).epsilon(1e-15));
  // A path that begins at its third station.
  CHECK(path.closest({0, 0, 10}, 2).point.md == 60);
  CHECK(path.closest({0, 0, 10}, 2).end == PathEnd::start);
}

TEST_CASE("A well that comes back is near twice, and both places are found in order of depth") {
  // Down, around a half circle of 100 m, and up again.
  const WellPath path = well_path(
      survey_of(
          {{0, 0, 0}, {300, 0, 0}, {300 + 50 * kPi, 90, 0}, {300 + 100 * kPi, 180, 0}, {600 + 100 * kPi, 180, 0}}),
      Vector3d::Zero());
  std::vector<ClosestPoint> minima;
  path.local_minima({90, 0, 150}, 0, minima);
  REQUIRE(minima.size() == 2);
  CHECK(minima[0].point.md == Approx(150).epsilon(1e-12));
  CHECK(minima[0].distance == Approx(90).epsilon(1e-12));
  CHECK(minima[1].point.md == Approx(450 + 100 * kPi).epsilon(1e-12));
  CHECK(minima[1].distance == Approx(110).epsilon(1e-12));
  CHECK(path.closest({90, 0, 150}, 0).point.md == Approx(150).epsilon(1e-12));
}
