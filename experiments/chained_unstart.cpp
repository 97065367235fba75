/// `chained_multistation`, study "unstart": how often do the solvers end elsewhere than at the lowest minimum, when
/// they begin far away, with and without the sub-search (slide 12, future work 1)?
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "chained_quantities.h"
#include "chained_studies.h"
#include "estimate/chained_attitude.h"
#include "estimate/chained_search.h"
#include "random/study_stream.h"
#include "study/comparison.h"

namespace surveymc {
namespace {

/// Ways to solve a run, in the order of the counts.
enum Way { kGaussNewton, kLevenberg, kSearchGaussNewton, kSearch };
constexpr std::size_t kWays = 4;
constexpr std::array<const char*, kWays> kWayNames{"gauss_newton", "levenberg", "search_gauss_newton", "search"};
enum Event {
  kNotConverged,  ///< no minimum at all
  kWrongMinimum,  ///< a minimum, but J is lower elsewhere
  kFailed         ///< either
};
constexpr std::size_t kEvents = 3;
constexpr std::array<const char*, kEvents> kEventNames{"not_converged", "higher_minimum", "failed"};
/// After the ways: of the runs themselves.
enum RunEvent { kAmbiguous, kTruthNotLowest, kTruthNotLowestUnflagged, kTruthNotFound };
constexpr std::size_t kRunEvents = 4;
constexpr std::array<const char*, kRunEvents> kRunEventNames{"ambiguous", "truth_not_lowest",
                                                             "truth_not_lowest_not_flagged", "truth_not_among_modes"};

struct Unstart {
  ChainedScenario s;
  bool given_start = false;  ///< all stations from `start`; otherwise from the basic solution
  Attitude start;
  double axial_bias = 0;  ///< nT, + in even trials, - in odd ones
};

class ChainedUnstart final : public StudyPoint {
 public:
  explicit ChainedUnstart(Unstart u) : u_(std::move(u)), stream_(stream_of(u_.s.seed)) {}

  Tally run_block(TrialBlock block) const override {
    Tally tally;
    tally.counts.assign(kWays * kEvents + kRunEvents, 0);
    for (int t = 0; t < block.count; ++t) {
      ++tally.trials;
      const RunOutcome r = outcome(block.first + static_cast<std::uint64_t>(t));
      for (std::size_t way = 0; way < kWays; ++way)
        for (std::size_t e = 0; e < kEvents; ++e) tally.counts[way * kEvents + e] += r.ways[way][e];
      for (std::size_t e = 0; e < kRunEvents; ++e) tally.counts[kWays * kEvents + e] += r.run[e];
    }
    return tally;
  }

  PointResult report(const Tally& tally, const RunOptions&) const override {
    std::vector<ComparisonRow> rows;
    const auto rate = [&](const std::string& formulation, const std::string& quantity, std::uint64_t count) {
      rows.push_back(compare_rate(quantity, count, tally.trials, std::nan(""), u_.s.verdict, tally.trials));
      rows.back().formulation = formulation;
      rows.back().note = fmt::format("{} of {} runs", count, tally.trials);
    };
    for (std::size_t way = 0; way < kWays; ++way)
      for (std::size_t e = 0; e < kEvents; ++e) rate(kWayNames[way], kEventNames[e], tally.counts[way * kEvents + e]);
    for (std::size_t e = 0; e < kRunEvents; ++e) rate("modes", kRunEventNames[e], tally.counts[kWays * kEvents + e]);
    // A search that may not fail: exactly no failure is what has to be seen
    for (ComparisonRow& row : rows)
      if (row.formulation == "search" && row.quantity == "failed") {
        row.analytic = 0;
        row.verdict = row.monte_carlo == 0 ? "agrees" : "differs";
      }
    u_.s.annotations.apply("unstart", rows);
    PointResult r;
    r.tables = {comparison_table("unstart",
                                 "runs that end elsewhere than at the lowest minimum, by how they are solved" +
                                     at_confidence(u_.s.verdict.confidence),
                                 rows, tally.trials, tally.failed)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const ChainedRun run = simulate(trial);
    const ChainedModel m = u_.s.model(ChainReferences::chained);
    std::string text = fmt::format("trial {}\n", trial);
    const ChainedModes modes = find_chained_modes(m, {run.readings, {}});
    for (const ChainedSolution& x : modes.modes)
      text += fmt::format("mode: cost {:.12g}, azimuth of the first station {:.9g} deg\n", x.cost,
                          attitude_of(x.stations[0].frame).azimuth / kDegree);
    text += modes.ambiguous ? "ambiguous\n" : "not ambiguous\n";
    return text;
  }

 private:
  struct RunOutcome {
    std::array<std::array<bool, kEvents>, kWays> ways{};
    std::array<bool, kRunEvents> run{};
  };

  ChainedRun simulate(std::uint64_t trial) const {
    ChainedRunSetup setup = u_.s.truth;
    setup.constant_state[kMagnetometerOffset + 2] += trial % 2 == 0 ? u_.axial_bias : -u_.axial_bias;
    return simulate_chained_run(setup, stream_, trial);
  }

  RunOutcome outcome(std::uint64_t trial) const {
    const ChainedRun run = simulate(trial);
    const ChainedModel m = u_.s.model(ChainReferences::chained);
    const ChainedReadings readings{run.readings, {}};
    ChainedPoint start = basic_start(m, readings);
    if (u_.given_start) std::fill(start.frames.begin(), start.frames.end(), frame_of(u_.start));
    ChainedPoint truth = start;
    truth.frames = run.frames;
    for (std::size_t k = 0; k < run.states.size(); ++k)
      truth.chain[k] = Eigen::Map<const ChainVector>(run.states[k].data());

    ChainedSearchOptions undamped;
    undamped.polish.damped = false;
    const ChainedModes modes = find_chained_modes(m, readings), raw = find_chained_modes(m, readings, undamped);
    const ChainedSolution at_truth = solve_chained(m, readings, truth);
    const ChainedSolution gauss_newton = solve_chained(m, readings, start, {.damped = false}),
                          levenberg = solve_chained(m, readings, start);
    const ChainedSolution* ends[kWays] = {&gauss_newton, &levenberg, raw.modes.empty() ? nullptr : &raw.modes[0],
                                          modes.modes.empty() ? nullptr : &modes.modes[0]};
    double lowest = at_truth.converged ? at_truth.cost : std::numeric_limits<double>::infinity();
    for (const ChainedSolution* end : ends)
      if (end && end->converged) lowest = std::min(lowest, end->cost);
    RunOutcome r;
    for (std::size_t way = 0; way < kWays; ++way) {
      const bool converged = ends[way] && ends[way]->converged;
      const bool higher = converged && ends[way]->cost > lowest + 1e-6;  // minima stand to 1e-9
      r.ways[way] = {!converged, higher, !converged || higher};
    }
    const bool not_lowest = at_truth.converged && at_truth.cost > lowest + 1e-6;
    const bool among = std::any_of(modes.modes.begin(), modes.modes.end(),
                                   [&](const auto& x) { return std::abs(x.cost - at_truth.cost) < 1e-6; });
    r.run = {modes.ambiguous, not_lowest, not_lowest && !modes.ambiguous, at_truth.converged && !among};
    return r;
  }

  Unstart u_;
  Stream stream_;
};

class ChainedUnstartPlan final : public PointPlan {
 public:
  explicit ChainedUnstartPlan(Unstart scenario) : s_(std::move(scenario)) {}
  std::uint64_t trials() const override { return s_.s.trials; }
  int block_trials() const override { return 8; }
  std::unique_ptr<StudyPoint> prepare(const RunOptions&) const override { return std::make_unique<ChainedUnstart>(s_); }

 private:
  Unstart s_;
};

}  // namespace

std::unique_ptr<PointPlan> chained_unstart(ConfigReader& c, StudySeed seed) {
  Unstart u;
  u.s = read_chained_scenario(c, seed);
  c.require(u.s.stations() <= 200, "profile.stations", "at most 200: every run is searched");
  const std::string from = c.choice("unstart.start", {"basic", "given"});
  u.given_start = from == "given";
  if (u.given_start)
    u.start = {kDegree * c.number("unstart.inclination_deg", Range::closed(0, 180)),
               kDegree * c.number("unstart.magnetic_azimuth_deg", Range::closed(-360, 360)),
               kDegree * c.number("unstart.toolface_deg", Range::closed(-360, 360))};
  u.axial_bias = c.number("unstart.axial_bias_nT", Range::closed(-20000, 20000), 0);
  std::vector<RowName> rows;
  for (const char* way : kWayNames)
    for (const char* e : kEventNames) rows.push_back({"unstart", way, e});
  for (const char* e : kRunEventNames) rows.push_back({"unstart", "modes", e});
  u.s.annotations = Annotations::read(c, rows);
  c.finish();
  return std::make_unique<ChainedUnstartPlan>(std::move(u));
}

}  // namespace surveymc
