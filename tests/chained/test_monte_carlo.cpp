/// 2000 runs of slide 11, by the lane kernel: RMS errors within 5 % of the independent program's, and a covariance that
/// holds. Sampling errors at 2000 runs: RMS of attitudes 1 %, of references 2.5 %, z-scores 1 to 1.5 %, J 0.23.
#include <Eigen/Cholesky>
#include <catch2/catch.hpp>

#include "chained/basic_solution.h"
#include "chained/batch.h"
#include "chained_cases.h"

using namespace surveymc;
using namespace surveymc::chained;
using namespace surveymc::chained_case;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr int kRuns = 2000, kLength = 18;

/// RMS of azimuth, inclination, toolface (deg), gravity (mg), horizontal and downward field (nT); z-scores, NEES, J.
struct Result {
  std::array<double, 6> rms{};
  std::array<double, 12> z{};
  double nees = 0, cost = 0;
};

std::array<double, 6> errors(const sensor::ChainedRun& run, std::size_t k, const Eigen::Matrix3d& frame, double g,
                             double bh, double bd) {
  const survey::Attitude a = attitude_of(frame), &t = run.attitudes[k];
  const auto degrees = [](double x) { return std::remainder(x, 2 * kPi) / kDegree; };
  return {degrees(a.azimuth - t.azimuth),
          degrees(a.inclination - t.inclination),
          degrees(a.toolface - t.toolface),
          (g - run.states[k][0]) / kMg,
          bh - run.states[k][1],
          bd - run.states[k][2]};
}
void add(Result& r, const std::array<double, 6>& e) {
  for (std::size_t i = 0; i < 6; ++i) r.rms[i] += e[i] * e[i] / (kRuns * kLength);
}

Runs runs_of(const sensor::ChainedRunSetup& setup) { return {setup, kRuns, random::Stream(31, 8)}; }

Result solved(const Runs& in, const Model& m, Mode mode) {
  BatchSolution out(kRuns, kLength);
  solve_batch(m, mode, in.batch, out);
  Result r;
  for (int t = 0; t < kRuns; ++t) {
    const sensor::ChainedRun& run = in.runs[static_cast<std::size_t>(t)];
    REQUIRE(out.converged(t));
    r.cost += out.cost(t) / kRuns;
    for (int k = 0; k < kLength; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const StationEstimate s = out.station(t, k);
      add(r, errors(run, i, s.frame, s.chain[0], s.chain[1], s.chain[2]));
      Eigen::Matrix<double, 12, 1> e;
      const Eigen::Vector3d turn = rotation_between(run.frames[i], s.frame);
      for (int j = 0; j < 3; ++j) e[j] = turn[j];
      e.tail<9>() = s.chain - vector_of(run.states[i]);
      for (int j = 0; j < 12; ++j)
        r.z[static_cast<std::size_t>(j)] += e[j] * e[j] / s.covariance(j, j) / (kRuns * kLength);
      r.nees += e.dot(s.covariance.llt().solve(e)) / (kRuns * kLength);
    }
  }
  for (double& x : r.rms) x = std::sqrt(x);
  for (double& x : r.z) x = std::sqrt(x);
  return r;
}

Result alone(const Runs& in, const Model& m, bool single) {
  Result r;
  for (const sensor::ChainedRun& run : in.runs)
    for (std::size_t k = 0; k < kLength; ++k) {
      const SingleStation s =
          single ? fully_optimised_station(m, single_weights(m), run.readings[k]) : basic_station(run.readings[k]);
      add(r, errors(run, k, s.frame, s.gravity - m.gravity, s.horizontal - m.horizontal, s.down - m.down));
    }
  for (double& x : r.rms) x = std::sqrt(x);
  return r;
}

void check_rms(const Result& r, const std::array<double, 6>& expected) {
  for (std::size_t i = 0; i < 6; ++i) CHECK_THAT(r.rms[i], WithinRel(expected[i], 0.05));
}

}  // namespace

TEST_CASE("RMS errors of slide 11 are those of an independent program", "[chained][long]") {
  const Model m = slide7();
  sensor::ChainedRunSetup setup = run_setup(m, building_profile(kLength));
  for (std::size_t i = 0; i < 3; ++i) {  // references in error by a constant
    setup.first_sd[i] = i == 0 ? 0.1 * kMg : 80;
    setup.step_sd[i] = 0;
  }
  const Runs in = runs_of(setup);
  check_rms(alone(in, m, false), {1.112, 0.052, 0.135, 0.901, 255, 314});
  check_rms(alone(in, m, true), {1.080, 0.052, 0.135, 0.102, 89, 87});
  check_rms(solved(in, slide7(ChainReferences::independent), Mode::filter), {0.617, 0.035, 0.114, 0.102, 72, 84});
  check_rms(solved(in, m, Mode::smoother), {0.486, 0.027, 0.084, 0.099, 36, 67});
}

TEST_CASE("The smoother's covariance is the scatter of its errors", "[chained][long]") {
  const Model m = slide7();
  const Runs in = runs_of(run_setup(m, building_profile(kLength)));
  for (const Mode mode : {Mode::smoother, Mode::filter}) {
    const Result r = solved(in, m, mode);
    for (const double z : r.z) CHECK_THAT(z, WithinAbs(1, 0.03));
    CHECK_THAT(r.nees, WithinAbs(12, 0.25));
    CHECK_THAT(r.cost, WithinAbs(54, 1));
  }
  // References observed anew at every station count one error many times.
  const Result optimistic = solved(in, slide7(ChainReferences::independent), Mode::filter);
  CHECK_THAT(optimistic.z[11], WithinAbs(1.37, 0.05));
}

TEST_CASE("The claims are the whole first order: what each draw does, squared, sums to them", "[chained][long]") {
  // All sizes a fiftieth. Each draw of a run alone, at plus and minus one sd: half the difference of the errors is its
  // first order, but for third orders, here 1e-4 or less.
  constexpr double scale = 0.02;
  constexpr int length = 7, per_station = 15, trials = 2 * per_station * length + 1;
  Model m = slide7();
  const auto shrink = [](auto& sizes) {
    for (double& x : sizes) x *= scale;
  };
  shrink(m.noise);
  shrink(m.prior_sd);
  shrink(m.link_sd);
  for (int well = 0; well < 30; ++well) {
    std::vector<survey::Attitude> attitudes;
    for (int k = 0; k < length; ++k)
      attitudes.push_back({(5 + 2.3 * well + 3 * k) * kDegree, (37 * well + (well % 7 - 3) * k) * kDegree,
                           (111 * well + 137.5 * k) * kDegree});
    sensor::ChainedRunSetup setup = run_setup(m, attitudes);
    setup.random_toolface = false;
    std::vector<sensor::ChainedRun> runs;
    Batch batch(trials, length);
    for (int t = 0; t < trials; ++t) {
      sensor::ChainedDraws draws{std::vector<std::array<double, 9>>(length, std::array<double, 9>{}),
                                 std::vector<std::array<double, 6>>(length, std::array<double, 6>{}),
                                 {}};
      const auto station = static_cast<std::size_t>(t / 2 / per_station),
                 i = static_cast<std::size_t>(t / 2 % per_station);
      if (t + 1 < trials) (i < 9 ? draws.steps[station][i] : draws.noise[station][i - 9]) = t % 2 == 0 ? 1 : -1;
      runs.push_back(sensor::chained_run_of(setup, draws));
      for (int k = 0; k < length; ++k) batch.set(t, k, runs.back().readings[static_cast<std::size_t>(k)]);
    }
    for (const Mode mode : {Mode::smoother, Mode::filter}) {
      BatchSolution out(trials, length);
      solve_batch(m, mode, batch, out);
      for (int k = 0; k < length; ++k) {
        const auto at = static_cast<std::size_t>(k);
        Eigen::Matrix<double, 12, 12> sum = Eigen::Matrix<double, 12, 12>::Zero();
        const auto error = [&](int t) {
          Eigen::Matrix<double, 12, 1> e;
          const StationEstimate s = out.station(t, k);
          e << rotation_between(runs[static_cast<std::size_t>(t)].frames[at], s.frame),
              s.chain - vector_of(runs[static_cast<std::size_t>(t)].states[at]);
          return e;
        };
        for (int t = 0; t + 1 < trials; t += 2) {
          REQUIRE((out.converged(t) && out.converged(t + 1)));
          const Eigen::Matrix<double, 12, 1> half = (error(t) - error(t + 1)) / 2;
          sum += half * half.transpose();
        }
        REQUIRE(out.converged(trials - 1));
        const Eigen::Matrix<double, 12, 12> claimed = out.station(trials - 1, k).covariance;
        for (int i = 0; i < 12; ++i)
          for (int j = 0; j <= i; ++j) {
            CAPTURE(well, static_cast<int>(mode), k, i, j);
            CHECK(std::abs(sum(i, j) - claimed(i, j)) < 1e-3 * std::sqrt(claimed(i, i) * claimed(j, j)));
          }
      }
    }
  }
}
