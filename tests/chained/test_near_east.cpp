/// Chained multistation near horizontal east and west, where Gauss-Newton runs to and fro and its covariance is too
/// small: the descent always ends at a minimum, and the profile's interval holds.
#include <random>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "chained/axial_profile.h"
#include "chained/batch.h"
#include "chained/smoother.h"
#include "chained_cases.h"

using namespace surveymc;
using namespace surveymc::chained;
using namespace surveymc::chained_case;
using Catch::Matchers::WithinAbs;

namespace {

/// Truth drawn from the model.
sensor::ChainedRun run_of(const Model& m, const std::vector<survey::Attitude>& attitudes, std::uint64_t trial) {
  return sensor::simulate_chained_run(run_setup(m, attitudes), random::Stream(31, 8), trial);
}

}  // namespace

TEST_CASE("The chain's curvature is the second difference of its cost", "[chained]") {
  Model m = slide7();
  m.interference.directions = Eigen::Matrix3d::Identity();
  Point p;
  p.frames = {frame_of({1.3, 0.7, 2.1})};
  p.chain = {ChainVector::Zero()};
  p.chain[0] << 0.001, 30, -40, 0.003, -0.002, 0.004, 100, -80, 300;
  p.interference = Eigen::Vector3d(500, -300, 200);
  const Readings r{{{0.3, -9, 2, 20000, -3000, 40000}}};
  const StationLinear l = linearise(m, r, p, 0);
  const StationCurvature c = curvature(m, l, p, 0);
  Eigen::Matrix<double, 6, 15> j;
  j << l.by_delta, l.by_chain, l.by_interference;
  Eigen::Matrix<double, 15, 15> half = j.transpose() * j;
  half.topLeftCorner<3, 3>() -= c.delta_delta;
  half.block<3, 3>(0, 3) -= c.delta_chain;
  half.block<3, 3>(3, 0) -= c.delta_chain.transpose();
  half.block<3, 3>(0, 12) -= c.delta_interference;
  half.block<3, 3>(12, 0) -= c.delta_interference.transpose();
  Eigen::Matrix<double, 15, 1> unit;  // steps that change the cost alike
  unit << 1, 1, 1, 1, 5000, 5000, 1, 1, 1, 5000, 5000, 5000, 5000, 5000, 5000;
  const auto cost = [&](const Eigen::Matrix<double, 15, 1>& x) {
    Point at = p;
    step_station(at, 0, x.head<3>(), x.segment<9>(3));
    at.interference += x.tail<3>();
    return readings_cost(m, r, at);
  };
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int direction = 0; direction < 30; ++direction) {
    Eigen::Matrix<double, 15, 1> v;
    for (int i = 0; i < 15; ++i) v[i] = normal(random) * unit[i];
    const double h = 1e-3, zero = cost(Eigen::Matrix<double, 15, 1>::Zero());
    const double second = (cost(h * v) - 2 * zero + cost(-h * v)) / (h * h);
    // Fourth order: h^2 of the whole; rounding: 1e-16 of the cost over h^2.
    CHECK_THAT(second, WithinAbs(2 * v.dot(half * v), 1e-5 * (zero + 2 * (j * v).squaredNorm())));
  }
}

TEST_CASE("Near horizontal east and west every run has its minimum, smoothed and filtered", "[chained][long]") {
  for (const double prior : {300.0, 1000.0, 3000.0})
    for (const double inclination : {80.0, 90.0})
      for (const double azimuth : {60.0, 85.0, 90.0, 270.0})
        for (std::uint64_t trial = 0; trial < 8; ++trial) {
          const Model m = loose(prior);
          INFO(prior << " nT, " << inclination << ", " << azimuth << ", trial " << trial);
          const Readings r{run_of(m, constant(inclination, azimuth), trial).readings};
          const Point start = basic_start(m, r);
          const Solution s = solve_blocks(m, r, start);
          REQUIRE(s.status == Status::converged);
          CHECK(s.cost <= chain_cost(m, r, start));
          CHECK(run_filter(m, r).status == Status::converged);
          CHECK(run_filter(loose(prior, ChainReferences::independent), r).status == Status::converged);
        }
}

TEST_CASE("What the descent ends at is a minimum: the cost rises to all sides", "[chained]") {
  const Model m = loose(3000);
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (std::uint64_t trial = 0; trial < 10; ++trial) {
    const Readings r{run_of(m, constant(90, 90), trial).readings};
    const Solution s = solve_blocks(m, r);
    REQUIRE(s.converged);
    for (int direction = 0; direction < 20; ++direction) {
      Point at = point_of(s);
      ChainVector dc;  // one for all stations: along the weak direction, too
      for (int i = 0; i < kChainStates; ++i) dc[i] = 0.05 * normal(random) * m.prior_sd[static_cast<std::size_t>(i)];
      const double turn = 0.01 * normal(random);
      for (int k = 0; k < 18; ++k) step_station(at, k, turn * at.frames[static_cast<std::size_t>(k)].col(2), dc);
      CHECK(chain_cost(m, r, at) > s.cost - 1e-9);
    }
  }
}

TEST_CASE("Readings that are no numbers end as such", "[chained]") {
  Readings r{run_of(slide7(), building_profile(18), 1).readings};
  r.y[3][2] = kNaN;
  CHECK(solve_blocks(slide7(), r).status == Status::not_finite);
  CHECK_FALSE(run_filter(slide7(), r).converged);
}

TEST_CASE("Where the lanes converge they are where the scalar filter is, hard attitudes too", "[chained]") {
  const Model m = loose(600);
  int converged = 0;
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    const Readings r{run_of(m, constant(90, 80), trial).readings};
    const Solution lanes = solve_alone(m, Mode::filter, r.y), scalar = run_filter(m, r);
    REQUIRE(scalar.converged);
    if (!lanes.converged) continue;
    ++converged;
    CHECK_THAT(lanes.cost, WithinAbs(scalar.cost, 1e-6));  // weak directions: 1e-9 of a prior sd, and a few of them
  }
  CHECK(converged > 0);
}

TEST_CASE("Where the claims are too small the profile says so, and its interval holds", "[chained][long]") {
  const Model m = loose(1000);
  constexpr int kRuns = 30;
  constexpr std::size_t kStation = 9;
  int inside = 0, unflagged = 0;
  double z2 = 0;
  const SearchOptions search{.attitudes = false};
  for (std::uint64_t trial = 0; trial < kRuns; ++trial) {
    const sensor::ChainedRun run = run_of(m, constant(90, 90), trial);
    const Readings r{run.readings};
    const Modes modes = find_modes(m, r, search);
    REQUIRE_FALSE(modes.modes.empty());
    const AxialProfile p = profile_azimuth(m, r, modes.modes, kStation);
    CHECK(p.complete);
    const double truth = run.attitudes[kStation].azimuth;
    inside += p.azimuth_low <= truth && truth <= p.azimuth_high;
    unflagged += p.parabola && std::abs(p.azimuth - truth) > 3 * p.azimuth_claimed_sd;
    z2 += (p.azimuth_mean - truth) * (p.azimuth_mean - truth) / (p.azimuth_sd * p.azimuth_sd) / kRuns;
  }
  // 95 % of 30 within 4 standard errors of 4 %; z^2 of mean 1 within 4 of sqrt(2/30)
  CHECK(inside >= 0.79 * kRuns);
  CHECK_THAT(z2, WithinAbs(1, 1.04));
  CHECK(unflagged == 0);
}

TEST_CASE("Where the model is nearly linear the claims hold, and the profile is the covariance", "[chained][long]") {
  const Model m = slide7();
  for (std::uint64_t trial = 0; trial < 3; ++trial) {
    const Readings r{run_of(m, building_profile(18), trial).readings};
    const std::vector<Solution> modes{solve_blocks(m, r)};
    for (const int station : {0, 9, 17}) {
      const AxialProfile p = profile_azimuth(m, r, modes, station, {}, true);
      CHECK(p.parabola);
      CHECK(p.complete);
      // Trapezoids of half an sd are exact for a Gaussian to 1e-8, steps that grow to a third of that: 2 %
      CHECK_THAT(p.azimuth_sd / p.azimuth_claimed_sd, WithinAbs(1, 0.05));
      CHECK_THAT(p.sd_bias / p.claimed_sd, WithinAbs(1, 0.05));
    }
  }
}
