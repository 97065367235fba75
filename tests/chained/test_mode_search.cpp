/// Far starts, second minima, wrong readings of chained multistation.
#include <catch2/catch.hpp>

#include "chained/mode_search.h"
#include "chained/reading_tests.h"
#include "chained_cases.h"

using namespace surveymc;
using namespace surveymc::chained;
using namespace surveymc::chained_case;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

Readings run_of(const Model& m, const std::vector<survey::Attitude>& attitudes, std::uint64_t trial,
                double axial_bias = 0) {
  sensor::ChainedRunSetup setup = run_setup(m, attitudes);
  setup.constant_state[kMagnetometerOffset + 2] = axial_bias;
  return {sensor::simulate_chained_run(setup, random::Stream(11, 8), trial).readings, {}};
}

}  // namespace

TEST_CASE("The attitude search needs no start", "[chained]") {
  const Model m = slide7();
  for (const double inclination : {0.0, 35.0, 90.0, 140.0}) {
    const std::vector<survey::Attitude> attitudes(3, {inclination * kDegree, 250 * kDegree, 0});
    const Readings r = run_of(m, attitudes, 1);
    const Solution from_search = solve_blocks(m, r, search_attitudes(m, r)), from_basic = solve_blocks(m, r);
    REQUIRE(from_search.converged);
    REQUIRE(from_basic.converged);
    CHECK_THAT(from_search.cost, WithinAbs(from_basic.cost, 1e-9));
  }
}

TEST_CASE("Near horizontal, an axial bias and the sign of cosA are told apart by the prior alone", "[chained]") {
  // A = 75 and A' = 105 differ by 2 Bh cos75 = 6699 nT of axial bias. Half of it, and a prior that allows both.
  ChainSizes sizes = slide7_sizes();
  sizes.magnetometer_z.offset = 1100;
  const Model m = make_model(sizes, 18, ChainReferences::chained);
  const std::vector<survey::Attitude> attitudes(18, {90 * kDegree, 75 * kDegree, 0});
  int ambiguous = 0;
  for (std::uint64_t trial = 0; trial < 6; ++trial) {
    const Modes modes = find_modes(m, run_of(m, attitudes, trial, -3350));
    REQUIRE(modes.modes.size() >= 2);
    CHECK(modes.modes[0].cost <= modes.modes[1].cost);
    const double first = attitude_of(modes.modes[0].stations[9].frame).azimuth / kDegree,
                 second = attitude_of(modes.modes[1].stations[9].frame).azimuth / kDegree;
    CHECK_THAT(first + second, WithinAbs(180, 6));  // mirror images, to the noise
    ambiguous += modes.ambiguous;
  }
  // The axial bias of a run scatters by 1100 nT about the middle: J differs by less than 13.8 within 1300 nT.
  CHECK(ambiguous >= 2);
  const Modes clear = find_modes(slide7(), run_of(slide7(), building_profile(18), 1));
  CHECK_FALSE(clear.ambiguous);
}

TEST_CASE("A wrong reading shifts its own test by its size times the sensitivity", "[chained]") {
  const Model m = slide7();
  const Readings clean = run_of(m, building_profile(18), 2);
  const Solution before = solve_blocks(m, clean);
  const ReadingTests tests = reading_tests(m, clean, before);
  for (std::size_t axis = 0; axis < 6; ++axis) {
    Readings wrong = clean;
    const double size = 0.5 * m.noise[axis];  // small: the model is not linear
    wrong.y[8][axis] += size;
    const ReadingTests after = reading_tests(m, wrong, solve_blocks(m, wrong));
    const double shift = size / m.noise[axis] * tests.sensitivity[8][axis];
    CHECK_THAT(after.w[8][axis] - tests.w[8][axis], WithinAbs(shift, 0.02));
    CHECK_THAT(minimal_detectable(m, tests, 8, axis, 4.2),
               WithinRel((4.2 + 0.8416212335729143) * m.noise[axis] / tests.sensitivity[8][axis], 1e-12));
  }
}

TEST_CASE("A gross error is blamed on its station; what is left out is not tested", "[chained]") {
  const Model m = slide7();
  Readings r = run_of(m, building_profile(18), 3);
  CHECK_FALSE(find_suspect(reading_tests(m, r, solve_blocks(m, r))).found);
  r.y[4][5] += 5000;
  const Suspect s = find_suspect(reading_tests(m, r, solve_blocks(m, r)));
  CHECK(s.found);
  CHECK(s.station == 4);
  CHECK(s.axis == 5);
  CHECK(s.dominant);
  r.left_out.assign(18, {});
  r.left_out[4][5] = true;
  const ReadingTests again = reading_tests(m, r, solve_blocks(m, r));
  CHECK(std::isnan(again.w[4][5]));
  CHECK_FALSE(find_suspect(again).found);
}
