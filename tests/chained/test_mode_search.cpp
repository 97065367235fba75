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

TEST_CASE("Descents side by side end where those of the block solver do, at the same minima", "[chained][long]") {
  // Slide 7 and a loose axial prior east-west, where Gauss-Newton is given up; chained and independent references; a
  // reading left out. Undamped, runs may jump for ever: only those that end in both ways are compared.
  for (const ChainReferences references : {ChainReferences::chained, ChainReferences::independent})
    for (const bool hard : {false, true})
      for (const bool damped : {true, false}) {
        const Model m = hard ? loose(3000, references) : slide7(references);
        const auto attitudes = hard ? constant(90, 90) : building_profile(18);
        Readings r = run_of(m, attitudes, 4, hard ? 3000 : 0);
        r.left_out.assign(18, {});
        r.left_out[7][2] = true;
        const Options options{.damped = damped};
        const std::vector<Point> starts = search_starts(m, r);
        const std::vector<Ended> ends = descend_all(m, r, starts, options);
        REQUIRE(ends.size() == starts.size());
        for (std::size_t i = 0; i < starts.size(); ++i) {
          const Ended plain = descend_blocks(m, r, starts[i], options);
          INFO(hard << damped << ", start " << i << ": " << plain.iterations << " and " << ends[i].iterations);
          if (damped) REQUIRE(ends[i].status == plain.status);
          if (plain.status != Status::converged || ends[i].status != Status::converged) continue;
          // The same steps to rounding, which may pass a limit one step earlier: another Hessian would take others
          CHECK(std::abs(ends[i].iterations - plain.iterations) <= 1);
          // Steps of 1e-9 of a prior sd: J, which is flat there, to its rounding
          CHECK_THAT(ends[i].cost, WithinAbs(plain.cost, cost_rounding(m, 18, plain.cost)));
          for (std::size_t k = 0; k < 18; ++k)
            CHECK(rotation_between(ends[i].at.frames[k], plain.at.frames[k]).norm() < 1e-7);
        }
      }
}

TEST_CASE("A start's end does not depend on the starts beside it", "[chained]") {
  const Model m = slide7();
  const Readings r = run_of(m, building_profile(18), 5);
  const std::vector<Point> starts = search_starts(m, r);
  const std::vector<Ended> together = descend_all(m, r, starts), alone = descend_all(m, r, {starts[3]});
  CHECK(together[3].cost == alone[0].cost);
  CHECK(together[3].iterations == alone[0].iterations);
  for (std::size_t k = 0; k < 18; ++k) {
    CHECK((together[3].at.chain[k].array() == alone[0].at.chain[k].array()).all());
    CHECK((together[3].at.frames[k].array() == alone[0].at.frames[k].array()).all());
  }
}

TEST_CASE("The offsets' search ends where its misfit rises to all sides", "[chained]") {
  const Model m = loose(3000);
  for (std::uint64_t trial = 0; trial < 4; ++trial) {
    const Readings r = run_of(m, constant(90, 90), trial, 3000);
    const std::vector<Offsets> starts{Offsets{}, {1, -1, 0.5, 0.3, -0.4, 1.5}};
    const std::vector<Offsets> ends = search_offsets_from(m, r, starts);
    REQUIRE(ends.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
      const double least = offset_misfit(m, r, ends[i]);
      CHECK(least <= offset_misfit(m, r, starts[i]));
      // Ended at steps of 1e-3 of a prior sd: ten times that is uphill, as the prior alone curves the misfit by 2
      for (std::size_t axis = 0; axis < 6; ++axis)
        for (const double side : {-1e-2, 1e-2}) {
          Offsets beside = ends[i];
          beside[axis] += side;
          CHECK(offset_misfit(m, r, beside) > least);
        }
    }
  }
}

TEST_CASE("Near horizontal, an axial bias and the sign of cosA are told apart by the prior alone", "[chained]") {
  // A = 75 and A' = 105 differ by 2 Bh cos75 = 6699 nT of axial bias. Half of it, and a prior that allows both.
  const Model m = loose(1100);
  int ambiguous = 0;
  for (std::uint64_t trial = 0; trial < 6; ++trial) {
    const Modes modes = find_modes(m, run_of(m, constant(90, 75), trial, -3350));
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
