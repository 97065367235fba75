#include "proximity/drawn_contact.h"

#include <cmath>
#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "config/error_model_file.h"
#include "proximity/contact_design.h"
#include "proximity/contact_state.h"
#include "proximity/touch_predictions.h"
#include "proximity/well_path.h"
#include "survey/minimum_curvature.h"
#include "wells.h"

using namespace surveymc;
using namespace surveymc::proximity;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

survey::Survey winding(unsigned seed, int stations) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> turn(-4, 4);
  survey::Survey s;
  double inclination = 60, azimuth = 40;
  for (int k = 0; k < stations; ++k, inclination += turn(generator), azimuth += turn(generator))
    s.stations.push_back({30.0 * k, inclination * kDegree, azimuth * kDegree, 0});
  return s;
}

DrawnPath drawn(const survey::Survey& s, const Vector3d& slot) {
  const WellPath path = well_path(s, slot);
  DrawnPath out;
  out.resize(path.stations());
  for (std::size_t k = 0; k < path.stations(); ++k)
    out.set(k, path.at_station(k).position, path.at_station(k).tangent, k == 0 ? 0 : path.md(k) - path.md(k - 1));
  return out;
}

Contact nearest(const DrawnPath& a, std::size_t first_a, const DrawnPath& b, std::size_t first_b, double below) {
  ContactScratch scratch;
  return nearest_contact(a, first_a, b, first_b, below, scratch);
}

}  // namespace

TEST_CASE("The nearest contact of two paths is that of continuous arcs", "[contact]") {
  // Against the closest points of the offset's arcs from 64 points a leg of the reference: never farther, and nearer by
  // no more than a sixty-fourth of a leg can make (s^2 / (2 D), s = 30 / 128 m along each well).
  for (unsigned seed = 0; seed < 20; ++seed) {
    const survey::Survey a = winding(seed, 40), b = winding(seed + 100, 40);
    const Vector3d slot(20, -15, 25);
    const Contact c = nearest(drawn(a, {0, 0, 0}), 0, drawn(b, slot), 0, kInfinity);
    const WellPath reference = well_path(a, {0, 0, 0}), offset = well_path(b, slot);
    double least = kInfinity;
    for (std::size_t leg = 0; leg + 1 < reference.stations(); ++leg)
      for (int i = 0; i <= 64; ++i)
        least = std::min(least, offset.closest(reference.at(leg, i / 64.0).position, 0).distance);
    CAPTURE(seed, least);
    CHECK(c.distance <= least + kContactError);
    CHECK(c.distance >= least - (30.0 / 128) * (30.0 / 128) / (2 * least) - 0.01 * least - kContactError);
    const Vector3d p = reference.at(c.reference_leg, c.reference_share).position,
                   q = offset.at(c.offset_leg, c.offset_share).position;
    CHECK_THAT((p - q).norm(), WithinAbs(c.distance, 0.01));
    // Below a threshold it is the same, and above it is the threshold.
    CHECK_THAT(nearest(drawn(a, {0, 0, 0}), 0, drawn(b, slot), 0, c.distance + 1).distance,
               WithinAbs(c.distance, 2 * kContactError));
    CHECK(nearest(drawn(a, {0, 0, 0}), 0, drawn(b, slot), 0, c.distance / 2).distance == c.distance / 2);
  }
}

TEST_CASE("Paths that are not finite, or turn back on themselves, have an end", "[contact]") {
  const Vector3d up(0, 0, -1);
  DrawnPath broken, back;
  broken.resize(2), back.resize(2);
  broken.set(0, {0, 0, 0}, up, 0);
  broken.set(1, {1, 2, 3}, {kNaN, kNaN, kNaN}, 30);
  back.set(0, {1e3, 0, 0}, up, 0);
  back.set(1, {1e3, 0, 0}, -up, 1e9);  // opposite directions
  const DrawnPath straight = drawn(winding(1, 2), {0, 0, 0});
  CHECK(nearest(broken, 0, straight, 0, kInfinity).distance == kInfinity);
  CHECK(nearest(straight, 0, broken, 0, 7).distance == 7);
  CHECK(nearest(back, 0, straight, 0, 7).distance <= 7);
}

TEST_CASE("The distance of beta is the least length of normals that make two points touch", "[contact]") {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  for (int run = 0; run < 50; ++run) {
    Eigen::Matrix3Xd j(3, 6);
    for (double& x : j.reshaped()) x = 4 * normal(generator);
    const Vector3d r(30 * normal(generator), 30 * normal(generator), 30 + 5 * normal(generator));
    Vector3d q;
    const double radii = 0.762, beta = touching_beta(r, j * j.transpose(), radii, &q);
    const Eigen::VectorXd z = design_of(j, r, q);
    CHECK_THAT(z.norm(), WithinRel(beta, 1e-9));
    CHECK_THAT((r + j * z).norm(), WithinRel(radii, 1e-9));
    // Nothing nearer touches: other points of the ball cost more.
    for (int i = 0; i < 20; ++i) {
      const Vector3d other = radii * Vector3d(normal(generator), normal(generator), normal(generator)).normalized();
      CHECK(design_of(j, r, other).norm() >= beta * (1 - 1e-9));
    }
  }
  // A spread in one direction alone reaches what lies in it, and nothing else.
  Matrix3d flat = Matrix3d::Zero();
  flat(0, 0) = 4;
  CHECK_THAT(touching_beta({10, 0, 0}, flat, 1), WithinRel(4.5, 1e-12));
  CHECK(std::isinf(touching_beta({10, 2, 0}, flat, 1)));
  CHECK(std::isinf(touching_beta({10, 0, 0}, Matrix3d::Zero(), 1)));
  CHECK(touching_beta({0.5, 0, 0}, flat, 1) == 0);
}

TEST_CASE("The disc has the probability of a conjunction of two satellites", "[contact]") {
  // First case of the unit test of PcCircle (nasa/CARA_Analysis_Tools), km. It takes |r| for the miss distance, the
  // disc r across the relative velocity: 2e-8 of the value.
  const Vector3d r1(378.39559, 4305.721887, 5752.767554), v1(2.360800244, 5.580331936, -4.322349039),
      r2(374.5180598, 4307.560983, 5751.130418), v2(-5.388125081, -3.946827739, 3.322820358);
  Matrix3d c;
  c << 44.5757544811362 + 2.31067077720423, 81.6751751052616 + 1.69905293875632, -67.8687662707124 - 1.4170164577661,
      81.6751751052616 + 1.69905293875632, 158.453402956163 + 1.24957388457206, -128.616921644857 - 1.04174164279599,
      -67.8687662707124 - 1.4170164577661, -128.616921644857 - 1.04174164279599, 105.490542562701 + 0.869260558223714;
  CHECK_THAT(touch_disc(r2 - r1, c, 0.020, (v2 - v1).normalized()), WithinRel(2.706023476569786e-05, 5e-8));
}

TEST_CASE("Predictions of one pair of points have the values of a quadrature", "[contact]") {
  // Two vertical wells, slots of sd (5, 8, 0) and (6, 9, 0) m, 25 m apart to the north, radii 0.762 m.
  Matrix3d c = Matrix3d::Zero();
  c.diagonal() << 61, 145, 1e-4;
  const Vector3d r(25, 0, 0);
  CHECK_THAT(touch_disc(r, c, 0.762, Vector3d::UnitZ()), WithinRel(1.858687e-5, 5e-7));
  CHECK_THAT(touch_slab(r, c, 0.762) / touch_disc(r, c, 0.762, Vector3d::UnitZ()), WithinAbs(25.5, 0.5));
  // A ball of an isotropic normal: 4/3 pi R^3 of its density, to second order in R.
  const Matrix3d ball = 400 * Matrix3d::Identity();
  const double density = std::exp(-625 / 800.0) / std::pow(2 * kPi * 400, 1.5);
  CHECK_THAT(touch_point(r, ball, 0.762), WithinRel(4.0 / 3 * kPi * std::pow(0.762, 3) * density, 1e-3));
  // Isotropic disc, D 20 m, radii 0.76 m: the most at sd = D / sqrt 2.
  for (const auto& [sd, p] : {std::pair(5.0, 4.03e-6), {10, 3.91e-4}, {14.142, 5.31e-4}, {20, 4.38e-4}, {40, 1.59e-4}})
    CHECK_THAT(touch_disc({20, 0, 0}, sd * sd * Matrix3d::Identity(), 0.76, Vector3d::UnitZ()), WithinRel(p, 2e-3));
}

TEST_CASE("A trial in which a well has no place is lost, and no miss", "[contact]") {
  const survey::Survey s = winding(1, 12);
  propagate::WellErrors good = propagate::well_errors(s, survey::true_vertical_depths(s),
                                                      {{1, test::shipped("MWD+SRGM")}}, test::field(), kNaN),
                        bad = good;
  bad.at[7].front().depth = kNaN;
  for (const auto& [a, b, is_lost] : {std::tuple(&good, &good, false), {&bad, &good, true}, {&good, &bad, true}}) {
    const ContactState state = contact_state({a, {0, 0, 0}, {0, 0, 0}, 0, 0}, {b, {0, 50, 0}, {0, 0, 0}, 0, 1}, {}, 1);
    survey::LaneArray z(1, state.dimension());
    for (int i = 0; i < state.dimension(); ++i)
      for (int t = 0; t < simd::kGroup; ++t) z.row(0, i)[t] = 0.1 * std::sin(i + 7.0 * t);
    double g[simd::kGroup], hits[simd::kGroup];
    state.evaluate(z, 1, g);
    state.evaluate_hits(z, 1, hits, nullptr);
    for (int t = 0; t < simd::kGroup; ++t) {
      CHECK(std::isnan(g[t]) == is_lost);
      CHECK(std::isnan(hits[t]) == is_lost);
    }
  }
}

TEST_CASE("Ways to touch are found between stations, whatever the length of the legs", "[contact]") {
  const auto straight = [](double azimuth, int legs, double length) {
    return test::survey_of(legs + 1, [&](int k) {
      return survey::Station{length * k, 90 * kDegree, azimuth * kDegree, 0};
    });
  };
  const double radii = 0.762, gap = 18, sd = 5;
  const auto found = [&](const survey::Survey& a, const survey::Survey& b, const Vector3d& slot, const Matrix3d& c) {
    return touching_pairs(
        well_path(a, {0, 0, 0}), 0, well_path(b, slot), 0, [&](const PathPoint&, const PathPoint&) { return c; }, radii,
        2.5, 12);
  };
  const Matrix3d round = sd * sd * Matrix3d::Identity(), flat = Vector3d(0, 0, sd * sd).asDiagonal();
  // Two legs that cross, also off their middles; errors up and down alone reach the crossing and nothing else.
  for (const double length : {30.0, 300.0, 8000.0})
    for (const double share : {0.5, 0.28})
      for (const Matrix3d& c : {round, flat}) {
        CAPTURE(length, share, c(0, 0));
        const auto pairs =
            found(straight(0, 1, length), straight(90, 1, length), {share * length, -(1 - share) * length, gap}, c);
        REQUIRE(pairs.size() == 1);
        CHECK_THAT(pairs[0].beta, WithinRel((gap - radii) / sd, 1e-6));
        CHECK_THAT(pairs[0].reference.md, WithinAbs(share * length, 0.1));
        CHECK_THAT(pairs[0].offset.md, WithinAbs((1 - share) * length, 0.1));
      }
  // There and back again: it crosses at a station of both, and as near in the middle of two legs.
  const survey::Survey twice = test::survey_of(
      {{0, 90, 90}, {240, 90, 90}, {600, 90, 90}, {720, 90, 0}, {840, 90, 270}, {900, 90, 270}, {1500, 90, 270}});
  const WellPath path = well_path(twice, {0, 0, 0});
  const double back = path.at_station(4).position.x();  // how far north it comes back
  const Vector3d slot(300, -240, gap);
  const survey::Survey reference = straight(0, 30, 30);
  CAPTURE(back);
  const auto pairs = found(reference, twice, slot, 9 * Matrix3d::Identity());
  REQUIRE(pairs.size() == 2);
  CHECK_THAT(pairs[0].beta, WithinRel(pairs[1].beta, 1e-4));
  CHECK_THAT(std::min(pairs[0].reference.md, pairs[1].reference.md), WithinAbs(300, 0.1));
  CHECK_THAT(std::max(pairs[0].reference.md, pairs[1].reference.md), WithinAbs(300 + back, 0.1));
}

TEST_CASE("An arc that crosses another well twice within one leg has two ways to touch", "[contact]") {
  // 20 degrees in 600 m, 90 - 0.87 deg of inclination: it passes over the other well, and under it 250 m later.
  const survey::Survey straight = test::survey_of({{0, 90, 0}, {600, 90, 0}}),
                       arc = test::survey_of({{0, 89.13, -10}, {600, 89.13, 10}});
  const Vector3d middle = well_path(arc, {0, 0, 0}).at(300).position;
  const WellPath reference = well_path(straight, {0, 0, 0}), offset = well_path(arc, Vector3d(300, -5, 0) - middle);
  const double radii = 0.5, sd = 0.5;
  const auto pairs = touching_pairs(
      reference, 0, offset, 0, [&](const PathPoint&, const PathPoint&) { return sd * sd * Matrix3d::Identity(); },
      radii, 2.5, 12);
  REQUIRE(pairs.size() == 2);
  for (const TouchingPair& p : pairs) {
    const double gap = (p.offset.position - p.reference.position).norm();
    CHECK_THAT(p.beta, WithinRel((gap - radii) / sd, 1e-9));
    CHECK_THAT(gap, WithinRel(pairs[0].beta * sd + radii, 1e-3));
    CHECK_THAT(std::abs(p.reference.md - 300), WithinAbs(125.6, 0.5));
  }
  CHECK((pairs[0].reference.md - 300) * (pairs[1].reference.md - 300) < 0);
}
