/// Study: chained multistation analysis estimates attitude, biases and references of all stations together, with biases
/// chained from station to station. It is compared with one station alone. Source: ISCWSA slides "Chained
/// multistation".
///
///   profile, toolfaces, walks and noise of a trial -> readings -> base, single, filter, smoother -> errors, claims
///
/// compared with the claims of the covariances: RMS, z-scores, NEES, and the cost with chi-squared(3 stations).
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "chained/block_solver.h"
#include "chained/smoother.h"
#include "chained_multistation/parts.h"
#include "chained_multistation/performance_tables.h"
#include "chained_multistation/quantities.h"
#include "config/suggest.h"
#include "random/study_stream.h"
#include "study/experiment.h"

namespace surveymc::studies::chained_multistation {
namespace {

class ChainedPerformance final : public study::StudyPoint {
 public:
  explicit ChainedPerformance(Scenario scenario)
      : s_(std::move(scenario)),
        layout_(s_),
        calibration_(s_),
        stop_(s_.trial_plan, s_.verdict, [this](const stats::Tally& t) { return performance_rows(s_, layout_, t); },
              {layout_.groups.size(), s_.estimators.size()}),
        stream_(random::stream_of(s_.seed)) {}

  std::uint64_t trials_needed(const stats::Tally& tally) const override { return stop_.trials_needed(tally); }

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally tally;
    tally.counts.assign(layout_.counts.size() + calibration_.size(), 0);
    PerformanceLayout::Block numbers = layout_.block(block.count, s_.stations());
    constexpr int kBatch = 64;  // trials whose readings and answers stay in the caches
    for (int first = 0; first < block.count; first += kBatch) {
      const int batch = std::min(kBatch, block.count - first);
      std::vector<sensor::ChainedRun> runs;
      chained::Batch readings(batch, s_.stations());
      for (int t = 0; t < batch; ++t) {
        runs.push_back(
            sensor::simulate_chained_run(s_.truth, stream_, block.first + static_cast<std::uint64_t>(first + t)));
        for (int k = 0; k < s_.stations(); ++k) readings.set(t, k, runs.back().readings[static_cast<std::size_t>(k)]);
      }
      std::vector<chained::BatchSolution> solved;
      for (const Solver e : s_.estimators) {
        solved.emplace_back(is_chained(e) ? batch : 0, s_.stations());
        if (is_chained(e)) chained::solve_batch(s_.model(references_of(e)), mode_of(e), readings, solved.back());
      }
      for (int t = 0; t < batch; ++t) {
        const sensor::ChainedRun& run = runs[static_cast<std::size_t>(t)];
        std::vector<RunCheck> checks;
        bool converged = true;
        for (std::size_t i = 0; i < s_.estimators.size(); ++i) {
          checks.push_back(check(s_.estimators[i], run, solved[i], t));
          converged = converged && checks.back().converged();
        }
        const std::uint64_t trial = block.first + static_cast<std::uint64_t>(first + t);
        ++tally.trials;
        if (!converged) tally.add_failed(trial);  // some estimator failed: the others keep the trial
        layout_.add(checks, numbers, tally.counts);
        calibration_.add(checks, tally.counts.data() + layout_.counts.size());
        if (trial < layout_.kept()) layout_.keep(checks, tally.samples);
      }
    }
    tally.groups = layout_.moments_of(numbers);
    stop_.keep(block, tally);
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    study::PointResult r;
    r.tables = performance_tables(s_, layout_, stop_, tally);
    for (store::Table& t : compare::calibration_tables(s_.calibration, calibration_.quantities(), tally.counts,
                                                       layout_.counts.size(), false, s_.annotations))
      r.tables.push_back(std::move(t));
    r.tables.push_back(tracks_table(s_, stream_));
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const sensor::ChainedRun run = sensor::simulate_chained_run(s_.truth, stream_, trial);
    std::string text = fmt::format("trial {}\n", trial);
    for (const Solver e : s_.estimators) {
      const RunCheck c = is_chained(e) ? check_chained(s_, run, solution_of(e, run)) : check_alone(s_, e, run);
      text += fmt::format("{}: {}", solver_names()[static_cast<std::size_t>(e)],
                          c.converged() ? "converged"
                                        : fmt::format("NOT converged ({})",
                                                      stats::kDescentStatusNames[static_cast<std::size_t>(c.status)]));
      text += is_chained(e) ? fmt::format(", cost {:.12g}\n", c.cost) : "\n";
      for (std::size_t k = 0; k < c.stations.size(); ++k) {
        text += fmt::format("  station {}: error", k + 1);
        for (std::size_t q = 0; q < kRunQuantities; ++q)
          text += fmt::format(" {} {:.12g}", kRunQuantityNames[q], c.stations[k].error[q]);
        text += "\n";
      }
    }
    return text;
  }

 private:
  /// By the damped solvers where the lanes gave up.
  RunCheck check(Solver e, const sensor::ChainedRun& run, const chained::BatchSolution& solved, int t) const {
    if (!is_chained(e)) return check_alone(s_, e, run);
    if (solved.converged(t)) return check_chained(s_, run, solved.solution(t));
    return check_chained(s_, run, solution_of(e, run));
  }
  chained::Solution solution_of(Solver e, const sensor::ChainedRun& run) const {
    const chained::Model m = s_.model(references_of(e));
    const chained::Solution lanes = chained::solve_alone(m, mode_of(e), run.readings);
    if (lanes.converged) return lanes;
    return mode_of(e) == chained::Mode::filter ? chained::run_filter(m, {run.readings, {}})
                                               : chained::solve_blocks(m, {run.readings, {}});
  }

  Scenario s_;
  PerformanceLayout layout_;
  PerformanceCalibration calibration_;
  compare::VerdictStop stop_;
  random::Stream stream_;
};

class ChainedPerformancePlan final : public study::PlanOfPoint<Scenario, ChainedPerformance> {
 public:
  using PlanOfPoint::PlanOfPoint;
  double cost() const override { return 1.0 * s_.stations() * static_cast<double>(s_.trial_plan.trials); }
  int block_trials() const override { return s_.stations() > 100 ? 32 : montecarlo::kBlockTrials; }
};

}  // namespace

std::unique_ptr<study::PointPlan> performance_plan(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s = read_scenario(c, seed, Purpose::performance);
  const std::vector<std::string>& names = solver_names();
  std::vector<std::string> wanted =
      c.has("estimators") ? c.texts("estimators", "estimators that are compared; without it all") : names;
  for (const std::string& name : wanted) {
    const auto found = std::find(names.begin(), names.end(), name);
    c.require(found != names.end(), "estimators", config::none_of(name, names));
    const auto e = static_cast<Solver>(found - names.begin());
    c.require(std::find(s.estimators.begin(), s.estimators.end(), e) == s.estimators.end(), "estimators",
              fmt::format("\"{}\" is there twice", name));
    s.estimators.push_back(e);
  }
  s.kept_runs = static_cast<std::size_t>(c.integer("kept_runs", 0, 1'000'000, "runs behind the table `runs`", 20'000));
  const std::vector<compare::Row> rows = rows_of(s);
  s.calibration = compare::read_calibration(c, rows);
  c.require(!s.calibration.on || std::any_of(s.estimators.begin(), s.estimators.end(), is_chained), "estimators",
            "none of them claims a covariance: with [calibration] one must be a filter or a smoother");
  s.trial_plan = compare::read_verdict_plan(c, rows, s.verdict, kTrialLimits);
  s.annotations = compare::Annotations::read(c, compare::annotated_rows(rows, s.calibration));
  c.finish();
  return std::make_unique<ChainedPerformancePlan>(std::move(s));
}

study::Experiment experiment() {
  study::Experiment e{
      random::StudyId::chained_multistation,
      "Attitudes, drifting biases and references of a run together: filter and smoother against single stations",
      "ISCWSA slides, chained multistation; slide 12's future work",
      [](config::ConfigReader& c, random::StudySeed seed) -> std::unique_ptr<study::PointPlan> {
        const std::string study = c.choice(
            "study", {"performance", "unstart", "outliers", "interference"},
            "what is asked: errors of the estimators, wrong starts, gross errors, or interference", "performance");
        if (study == "unstart") return unstart_plan(c, seed);
        if (study == "outliers") return outliers_plan(c, seed);
        if (study == "interference") return interference_plan(c, seed);
        return performance_plan(c, seed);
      }};
  e.approximations = {"ignored", "form"};
  return e;
}

}  // namespace surveymc::studies::chained_multistation
