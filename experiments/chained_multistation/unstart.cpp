/// `chained_multistation`, study "unstart": how often do the solvers not end at the lowest minimum when they begin far
/// away, with and without the sub-search (slide 12, future work 1)?
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "chained/attitude.h"
#include "chained/mode_search.h"
#include "chained_multistation/parts.h"
#include "chained_multistation/quantities.h"
#include "compare/comparison.h"
#include "random/study_stream.h"

namespace surveymc::studies::chained_multistation {
namespace {

/// Ways to solve a run, in the order of the counts.
enum UnstartWay { kGaussNewton, kLevenberg, kSearchGaussNewton, kSearch };
constexpr std::size_t kUnstartWays = 4;
constexpr std::array<const char*, kUnstartWays> kUnstartWayNames{"gauss_newton", "levenberg", "search_gauss_newton",
                                                                 "search"};
enum UnstartEvent {
  kNotConverged,  ///< no minimum at all
  kWrongMinimum,  ///< a minimum, but J is lower elsewhere
  kFailed         ///< either
};
constexpr std::size_t kUnstartEvents = 3;
constexpr std::array<const char*, kUnstartEvents> kUnstartEventNames{"not_converged", "higher_minimum", "failed"};
/// After the ways: of the runs themselves.
enum UnstartRunEvent { kAmbiguous, kTruthNotLowest, kTruthNotLowestUnflagged, kTruthNotFound };
constexpr std::size_t kUnstartRunEvents = 4;
constexpr std::array<const char*, kUnstartRunEvents> kUnstartRunEventNames{
    "ambiguous", "truth_not_lowest", "truth_not_lowest_not_flagged", "truth_not_among_modes"};

struct Unstart : Scenario {
  bool given_start = false;  ///< all stations from `start`; otherwise from the basic solution
  survey::Attitude start = {};
  double axial_bias = 0;  ///< nT, + in even trials, - in odd ones
};

class ChainedUnstart final : public study::StudyPoint {
 public:
  explicit ChainedUnstart(Unstart u) : u_(std::move(u)), stream_(random::stream_of(u_.seed)) {}

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally tally;
    tally.counts.assign(kUnstartWays * kUnstartEvents + kUnstartRunEvents, 0);
    for (int t = 0; t < block.count; ++t) {
      ++tally.trials;
      const RunOutcome r = outcome(block.first + static_cast<std::uint64_t>(t));
      for (std::size_t way = 0; way < kUnstartWays; ++way)
        for (std::size_t e = 0; e < kUnstartEvents; ++e) tally.counts[way * kUnstartEvents + e] += r.ways[way][e];
      for (std::size_t e = 0; e < kUnstartRunEvents; ++e) tally.counts[kUnstartWays * kUnstartEvents + e] += r.run[e];
    }
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    std::vector<compare::ComparisonRow> rows;
    const auto rate = [&](const std::string& formulation, const std::string& quantity, std::uint64_t count) {
      const double predicted = formulation == "search" && quantity == "failed" ? 0 : kNaN;  // the search must not fail
      rows.push_back(compare::compare_rate(quantity, count, tally.trials, predicted, u_.verdict, tally.trials));
      rows.back().formulation = formulation;
      rows.back().note = fmt::format("{} of {} runs", count, tally.trials);
    };
    for (std::size_t way = 0; way < kUnstartWays; ++way)
      for (std::size_t e = 0; e < kUnstartEvents; ++e)
        rate(kUnstartWayNames[way], kUnstartEventNames[e], tally.counts[way * kUnstartEvents + e]);
    for (std::size_t e = 0; e < kUnstartRunEvents; ++e)
      rate("modes", kUnstartRunEventNames[e], tally.counts[kUnstartWays * kUnstartEvents + e]);
    u_.annotations.apply("unstart", rows);
    study::PointResult r;
    r.tables = {compare::comparison_table("unstart",
                                          "runs that end elsewhere than at the lowest minimum, by how they are solved" +
                                              compare::at_confidence(u_.verdict.confidence),
                                          rows, tally.trials, tally.failed)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const sensor::ChainedRun run = simulate(trial);
    const chained::Model m = u_.model(chained::ChainReferences::chained);
    std::string text = fmt::format("trial {}\n", trial);
    const chained::Modes modes = chained::find_modes(m, {run.readings, {}});
    for (const chained::Solution& x : modes.modes)
      text += fmt::format("mode: cost {:.12g}, azimuth of the first station {:.9g} deg\n", x.cost,
                          chained::attitude_of(x.stations[0].frame).azimuth / kDegree);
    text += modes.ambiguous ? "ambiguous\n" : "not ambiguous\n";
    return text;
  }

 private:
  struct End {
    bool converged = false;
    double cost = 0;
  };
  struct RunOutcome {
    std::array<std::array<bool, kUnstartEvents>, kUnstartWays> ways{};
    std::array<bool, kUnstartRunEvents> run{};
  };

  sensor::ChainedRun simulate(std::uint64_t trial) const {
    sensor::ChainedRunSetup setup = u_.truth;
    setup.constant_state[chained::kMagnetometerOffset + 2] += trial % 2 == 0 ? u_.axial_bias : -u_.axial_bias;
    return sensor::simulate_chained_run(setup, stream_, trial);
  }

  RunOutcome outcome(std::uint64_t trial) const {
    const sensor::ChainedRun run = simulate(trial);
    const chained::Model m = u_.model(chained::ChainReferences::chained);
    const chained::Readings readings{run.readings, {}};
    chained::Point start = chained::basic_start(m, readings);
    if (u_.given_start) std::fill(start.frames.begin(), start.frames.end(), chained::frame_of(u_.start));
    chained::Point truth = start;
    truth.frames = run.frames;
    for (std::size_t k = 0; k < run.states.size(); ++k)
      truth.chain[k] = Eigen::Map<const chained::ChainVector>(run.states[k].data());

    // All ways descend from the same starts, side by side: those of the search, the study's own, the truth
    const std::vector<chained::Point> search = chained::search_starts(m, readings);
    std::vector<chained::Point> starts = search;
    starts.push_back(truth);
    if (u_.given_start) starts.push_back(start);
    chained::SearchOptions damped, undamped;
    undamped.polish.damped = false;
    std::vector<chained::Ended> ends_damped = chained::descend_all(m, readings, starts, damped.polish),
                                ends_undamped = chained::descend_all(m, readings, starts, undamped.polish);
    const auto own = u_.given_start ? starts.size() - 1 : 0;  // the basic solution is the search's first start
    const auto end_of = [](const chained::Ended& e) { return End{e.status == chained::Status::converged, e.cost}; };
    const End at_truth = end_of(ends_damped[search.size()]);
    End ends[kUnstartWays] = {end_of(ends_undamped[own]), end_of(ends_damped[own]), {}, {}};
    ends_damped.resize(search.size());
    ends_undamped.resize(search.size());
    const chained::Modes modes = chained::find_modes(m, readings, ends_damped, damped),
                         raw = chained::find_modes(m, readings, ends_undamped, undamped);
    if (!raw.modes.empty()) ends[kSearchGaussNewton] = {true, raw.modes[0].cost};
    if (!modes.modes.empty()) ends[kSearch] = {true, modes.modes[0].cost};
    double lowest = at_truth.converged ? at_truth.cost : kInfinity;
    for (const End& end : ends)
      if (end.converged) lowest = std::min(lowest, end.cost);
    RunOutcome r;
    for (std::size_t way = 0; way < kUnstartWays; ++way) {
      const bool converged = ends[way].converged;
      const bool higher = converged && ends[way].cost > lowest + 1e-6;  // minima stand to 1e-9
      r.ways[way] = {!converged, higher, !converged || higher};
    }
    const bool not_lowest = at_truth.converged && at_truth.cost > lowest + 1e-6;
    const bool among = std::any_of(modes.modes.begin(), modes.modes.end(),
                                   [&](const auto& x) { return std::abs(x.cost - at_truth.cost) < 1e-6; });
    r.run = {modes.ambiguous, not_lowest, not_lowest && !modes.ambiguous, at_truth.converged && !among};
    return r;
  }

  Unstart u_;
  random::Stream stream_;
};

}  // namespace

std::unique_ptr<study::PointPlan> unstart_plan(config::ConfigReader& c, random::StudySeed seed) {
  Unstart u{read_scenario_of_fixed_length(c, seed)};
  c.require(u.stations() <= 200, "profile.stations", "at most 200: every run is searched");
  const std::string from =
      c.choice("unstart.start", {"basic", "given"},
               "start of every solution: 'basic': single-station attitudes; 'given': one attitude for all stations");
  u.given_start = from == "given";
  if (u.given_start)
    u.start = {kDegree * c.number("unstart.inclination_deg", config::Range::closed(0, 180),
                                  "given start: inclination of all stations"),
               kDegree * c.number("unstart.magnetic_azimuth_deg", config::Range::closed(-360, 360),
                                  "given start: azimuth of all stations"),
               kDegree * c.number("unstart.toolface_deg", config::Range::closed(-360, 360),
                                  "given start: toolface of all stations")};
  u.axial_bias = c.number("unstart.axial_bias_nT", config::Range::closed(-20000, 20000),
                          "added to the axial magnetometer, with the other sign in odd trials", 0);
  std::vector<compare::Row> rows;
  for (const char* way : kUnstartWayNames)
    for (const char* e : kUnstartEventNames) rows.push_back({"unstart", way, e});
  for (const char* e : kUnstartRunEventNames) rows.push_back({"unstart", "modes", e});
  u.annotations = compare::Annotations::read(c, rows);
  c.finish();
  return std::make_unique<study::PlanOfPoint<Unstart, ChainedUnstart, 8>>(std::move(u));
}

}  // namespace surveymc::studies::chained_multistation
