#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "proximity/pair_scan.h"
#include "survey/minimum_curvature.h"
#include "wells.h"

using namespace surveymc;
using namespace surveymc::proximity;
using namespace surveymc::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

struct Well {
  survey::Survey survey;
  WellPath path;
  std::shared_ptr<const PositionErrors> errors;

  Well(survey::Survey s, const Vector3d& slot) : survey(std::move(s)), path(well_path(survey, slot)) {
    errors = std::make_shared<const PositionErrors>(position_errors(survey, survey::true_vertical_depths(survey),
                                                                    {{1, shipped("iscwsa_mwd_rev5.10")}}, field(), kNaN,
                                                                    Interpolation::covariance));
  }
};

/// Vertical, then a build of 3 deg a station from station `from` on up to `most` deg.
survey::Survey build(int stations, int from, double most, double azimuth) {
  return survey_of(stations, [&](int k) {
    return survey::Station{30.0 * k, std::clamp(3.0 * (k - from), 0.0, most) * kDegree, azimuth * kDegree, 0};
  });
}
survey::Survey straight(int stations, double inclination, double azimuth) {
  return survey_of(stations, [&](int k) {
    return survey::Station{30.0 * k, inclination * kDegree, azimuth * kDegree, 0};
  });
}

PairGeometry geometry_of(const Well& reference, const Well& offset) {
  return {&reference.path, &offset.path, &reference.survey, {}, 0.762, 0};
}
PairErrors formulation(const Well& reference, const Well& offset, Sharing sharing) {
  PairErrors e{"", reference.errors, offset.errors, {}, true};
  e.common.sources = shared_sources(sharing, {}, *reference.errors, *offset.errors);
  e.is_independent = e.common.sources.empty();
  return e;
}

}  // namespace

TEST_CASE("Direction to the offset: from north, and from the high side of a vertical hole as its azimuth is listed") {
  const Well reference(straight(4, 0, 30), Vector3d::Zero()), offset(straight(4, 0, 0), {0, 100, 0});
  const PairPoints p = pair_at(geometry_of(reference, offset), ScanDirection::reference, 60);
  CHECK(p.distance == 100);
  CHECK(p.bearing == Approx(90 * kDegree).epsilon(1e-14));
  CHECK(p.toolface == Approx(60 * kDegree).epsilon(1e-14));
  CHECK(p.offset.md == 60);
  CHECK(p.end == PathEnd::interior);
  // A point straight below has no bearing and, seen along the hole, no toolface.
  const Well below(straight(4, 90, 0), {0, 0, 200});
  const PairPoints down = pair_at(geometry_of(reference, below), ScanDirection::reference, 60);
  CHECK(std::isnan(down.bearing));
  CHECK(std::isnan(down.toolface));
  CHECK(down.end == PathEnd::start);
}

TEST_CASE("Straight holes that cross: the least distance between stations, from either well") {
  // The reference goes down; the offset goes east at 100 m depth, 7 m north of it, from 200 m west on.
  const Well reference(straight(8, 0, 0), Vector3d::Zero()), offset(straight(14, 90, 90), {7, -200, 100});
  const PairGeometry g = geometry_of(reference, offset);
  for (const ScanDirection direction : {ScanDirection::reference, ScanDirection::offset}) {
    const auto pairs = scan(g, direction, 0, 1);
    CHECK(pairs.size() == (direction == ScanDirection::reference ? 8 : 14));
    const auto least = least_clearance(g, formulation(reference, offset, Sharing::none), direction, pairs,
                                       least_samples(g, direction));
    const Least& distance = least[1];
    // Stations at 90 and 120 m down; along the offset at 180 and 210 m, 10 m from the crossing.
    CHECK(distance.at_station == Approx(std::hypot(7, 10)).epsilon(1e-12));
    CHECK(distance.continuous == Approx(7).epsilon(1e-12));
    CHECK(distance.pair.reference.md == Approx(100).epsilon(1e-6));
    CHECK(distance.pair.offset.md == Approx(200).epsilon(1e-6));
    for (const Least& x : least) CHECK(x.continuous <= x.at_station);
  }
}

TEST_CASE("Least values are those of a dense scan, and the separation factor is not least where the distance is") {
  const Well reference(build(80, 20, 60, 0), Vector3d::Zero()), offset(build(85, 14, 50, 350), {-300, 60, 0});
  const PairGeometry g = geometry_of(reference, offset);
  for (const Sharing sharing : {Sharing::none, Sharing::geomagnetic}) {
    const PairErrors errors = formulation(reference, offset, sharing);
    const auto least = least_clearance(g, errors, ScanDirection::reference, scan(g, ScanDirection::reference, 0, 1),
                                       least_samples(g, ScanDirection::reference));
    std::array<double, 3> found{HUGE_VAL, HUGE_VAL, HUGE_VAL};
    for (const PairPoints& p : scan(g, ScanDirection::reference, 0.25, 1)) {
      const PairClearance c = clearance_of(g, errors, p, false);
      found[0] = std::min(found[0], c.separation_factor);
      found[1] = std::min(found[1], p.distance);
      if (std::isfinite(c.mahalanobis)) found[2] = std::min(found[2], c.mahalanobis);
    }
    for (std::size_t q = 0; q < 3; ++q) {
      CAPTURE(q);
      CHECK(least[q].continuous <= found[q] * (1 + 1e-9));
      // The nearest sample is 0.125 m away at most, where a minimum has risen by less than 1e-4 of itself.
      CHECK(least[q].continuous >= found[q] * (1 - 1e-4));
      CHECK(least[q].continuous <= least[q].at_station);
    }
    CHECK(std::abs(least[0].pair.reference.md - least[1].pair.reference.md) > 30);
  }
}

TEST_CASE("In every pair the pedal radius is no less cautious than Mahalanobis, and the ellipsoids lie between") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> azimuth(0, 360), slot(-400, 400);
  int rows = 0;
  for (int i = 0; i < 12; ++i) {
    const Well reference(build(60, 20, 60, azimuth(random)), Vector3d::Zero()),
        offset(build(70, 15, 90, azimuth(random)), {slot(random), slot(random), 0});
    const PairGeometry g = geometry_of(reference, offset);
    for (const Sharing sharing : {Sharing::none, Sharing::geomagnetic, Sharing::pad})
      for (const ScanDirection direction : {ScanDirection::reference, ScanDirection::offset})
        for (const PairPoints& p : scan(g, direction, 0, 1)) {
          const PairClearance c = clearance_of(g, formulation(reference, offset, sharing), p, true);
          CHECK(c.sigma_distance <= c.mahalanobis * (1 + 1e-9));
          if (sharing == Sharing::none && std::isfinite(c.mahalanobis)) {
            CHECK(c.ellipsoid_factor <= c.mahalanobis * (1 + 1e-9));
            CHECK(c.ellipsoid_factor >= c.mahalanobis / std::sqrt(2) * (1 - 1e-9));
            CHECK(c.sd_relative == Approx(std::hypot(c.sd_reference, c.sd_offset)).epsilon(1e-12));
          }
          if (sharing != Sharing::none) CHECK(std::isnan(c.ellipsoid_factor));
          ++rows;
        }
  }
  CHECK(rows > 4000);
}

TEST_CASE("Parallel wells are known better relative to each other when they share the field, opposing wells worse") {
  const auto factor = [](double azimuth, const Vector3d& slot, Sharing sharing) {
    const Well reference(build(90, 20, 60, 90), Vector3d::Zero()), offset(build(90, 20, 60, azimuth), slot);
    const PairGeometry g = geometry_of(reference, offset);
    return clearance_of(g, formulation(reference, offset, sharing), scan(g, ScanDirection::reference, 0, 1).back(),
                        false)
        .separation_factor;
  };
  CHECK(factor(90, {60, 0, 0}, Sharing::geomagnetic) > factor(90, {60, 0, 0}, Sharing::none));
  // From the east towards the reference, side by side at its end.
  CHECK(factor(270, {60, 2600, 0}, Sharing::geomagnetic) < factor(270, {60, 2600, 0}, Sharing::none));
}

TEST_CASE("A scan lists farther minima up to the share that is asked for, and points between stations") {
  survey::Survey u;  // down, around a half circle of 100 m, and up again
  u.stations = {{0, 0, 0, 0},
                {300, 0, 0, 0},
                {300 + 50 * kPi, 90 * kDegree, 0, 0},
                {300 + 100 * kPi, 180 * kDegree, 0, 0},
                {600 + 100 * kPi, 180 * kDegree, 0, 0}};
  const Well reference(straight(6, 0, 0), {90, 0, 60}), offset(u, Vector3d::Zero());
  const PairGeometry g = geometry_of(reference, offset);
  CHECK(scan(g, ScanDirection::reference, 0, 1).size() == 6);
  const auto both = scan(g, ScanDirection::reference, 0, 1.3);
  REQUIRE(both.size() == 12);
  CHECK(both[0].minimum == 1);
  CHECK(both[0].distance == Approx(90).epsilon(1e-12));
  CHECK(both[1].minimum == 2);
  CHECK(both[1].distance == Approx(110).epsilon(1e-12));
  CHECK(scan(g, ScanDirection::reference, 0, 1.2).size() == 6);  // 110 > 1.2 * 90
  const auto steps = scan(g, ScanDirection::reference, 12.5, 1);
  CHECK(steps.size() == 6 + 11);  // 12.5 to 137.5; 0 and 150 are stations
  for (std::size_t i = 1; i < steps.size(); ++i) CHECK(steps[i].reference.md > steps[i - 1].reference.md);
}

TEST_CASE("Where the centre lines meet there is no direction, and the factor is that of the holes alone") {
  const Well reference(straight(5, 0, 0), Vector3d::Zero()), offset(straight(5, 90, 90), {0, 0, 60});
  const PairGeometry g = geometry_of(reference, offset);
  const PairPoints p = pair_at(g, ScanDirection::reference, 60);
  const PairClearance c = clearance_of(g, formulation(reference, offset, Sharing::none), p, true);
  CHECK(p.distance == 0);
  CHECK(std::isnan(p.bearing));
  CHECK(c.sd_relative == 0);
  CHECK(c.separation_factor == Approx(-(0.762 + 0.3) / (3.5 * 0.5)).epsilon(1e-14));
  CHECK(c.sigma_distance == 0);
  CHECK(c.mahalanobis == 0);
  CHECK(c.ellipsoid_factor == 0);
  // Two holes that are one down to 600 m and part there: rounding gives no direction.
  survey::Survey s = build(40, 10, 60, 20), other = s;
  for (std::size_t k = 21; k < other.stations.size(); ++k) other.stations[k].azimuth += 5 * kDegree;
  const Well main(s, {1000, -2000, 30}), side(other, {1000, -2000, 30});
  for (const PairPoints& pair : scan(geometry_of(main, side), ScanDirection::reference, 7, 1))
    CHECK((pair.distance == 0) == (pair.reference.md <= 600));
}
