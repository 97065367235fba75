/// Study: are gross errors found as often as the tests were designed to, and are the right readings blamed? By Monte
/// Carlo with the nonlinear adjustment. Source: Nyrnes, Torkildsen, Nahavandchi, sections 2.1 and 2.2; the paper has
/// the theory only.
///
///   true attitude -> readings with noise -> adjusted without errors (false alarms)
///                                        -> and with the errors in -> tests, snooping -> tally
///
/// compared with the designed level and power: linear theory, and the shift of the test by the nonlinear adjustment of
/// readings with the errors but without noise.
#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "compare/table_rows.h"
#include "gross_error_detection/tables.h"
#include "random/study_stream.h"
#include "reliability/gross_error_lanes.h"
#include "reliability/snooping.h"
#include "study/experiment.h"

namespace surveymc::studies::gross_error_detection {
namespace {

using Numbers = std::vector<Eigen::Index>;

bool contains(const Numbers& all, Eigen::Index one) { return std::find(all.begin(), all.end(), one) != all.end(); }

/// A bipartite matching of rejected groups and errors, by augmenting paths.
struct Matching {
  const std::vector<reliability::SuspectGroup>& rejected;
  const Numbers& errors;
  std::vector<std::optional<std::size_t>> group_of;  ///< of each error, if any

  /// Gives group `k` an error that it holds and that was not `tried`; a group that had it takes another one.
  bool give(std::size_t k, std::vector<bool>& tried) {
    for (std::size_t e = 0; e < errors.size(); ++e) {
      if (tried[e] || !contains(rejected[k], errors[e])) continue;
      tried[e] = true;
      if (group_of[e] && !give(*group_of[e], tried)) continue;
      group_of[e] = k;
      return true;
    }
    return false;
  }
};

/// Are the errors the rejected groups, one each?
bool matches(const std::vector<reliability::SuspectGroup>& rejected, const Numbers& errors) {
  if (rejected.size() != errors.size()) return false;
  Matching m{rejected, errors, std::vector<std::optional<std::size_t>>(errors.size())};
  for (std::size_t k = 0; k < rejected.size(); ++k) {
    std::vector<bool> tried(errors.size(), false);
    if (!m.give(k, tried)) return false;
  }
  return true;
}

SnoopingOutcome judge_snooping(const reliability::SnoopingResult& r, const Numbers& errors) {
  if (r.rejected.empty()) return SnoopingOutcome::missed;
  const bool right = matches(r.rejected, errors);
  const bool among_ties =
      std::any_of(r.ties.begin(), r.ties.end(), [&](const auto& tie) { return matches(tie, errors); });
  if (right || among_ties) {
    const bool alone = std::all_of(r.rejected.begin(), r.rejected.end(), [](const auto& g) { return g.size() == 1; });
    return right && alone && r.ties.empty() ? SnoopingOutcome::identified : SnoopingOutcome::group;
  }
  for (const reliability::SuspectGroup& g : r.rejected)
    for (const Eigen::Index e : errors)
      if (contains(g, e)) return SnoopingOutcome::partly;
  return SnoopingOutcome::wrong;
}

class GrossErrorDetection final : public study::StudyPoint {
 public:
  GrossErrorDetection(Scenario scenario, reliability::GrossErrorTrials trials,
                      analysis::GrossErrorPrediction prediction)
      : s_(std::move(scenario)),
        trials_(std::move(trials)),
        prediction_(std::move(prediction)),
        layout_{s_.injected.size(), s_.strategies.size()},
        stop_(s_.trial_plan, s_.verdict,
              [this](const stats::Tally& t) {
                return compare::RowsOfTables{{"detection", detection_rows(s_, prediction_, t)}};
              },
              {0, 0, 0, 0, layout_.size(), true}) {
    for (const InjectedError& e : s_.injected) errors_.push_back(e.error.number);
  }

  std::uint64_t trials_needed(const stats::Tally& tally) const override { return stop_.trials_needed(tally); }

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally tally;
    tally.counts.assign(layout_.size(), 0);
    Eigen::MatrixXd shares(block.count, 1);  // of the tests that raise a false alarm
    Eigen::Index kept = 0;
    survey::LaneArray without, with;
    const int groups = survey::groups_for(block.count);
    const bool shots = trials_.shots_on_lanes();
    reliability::RedundancyFamily family;  // of one trial after the other
    if (trials_.on_lanes()) {
      without = survey::LaneArray(groups, reliability::kTestRows);
      with = survey::LaneArray(groups, reliability::kTestRows);
      trials_.simulate(block.first, without, with, groups);
    } else if (shots) {
      without = survey::LaneArray(groups, trials_.shots_rows().tests());
      with = survey::LaneArray(groups, trials_.shots_rows().all());
      trials_.simulate_shots(block.first, without, with, groups);
    }
    for (int t = 0; t < block.count; ++t) {
      const std::uint64_t trial = block.first + static_cast<std::uint64_t>(t);
      ++tally.trials;
      bool converged = false;
      if (trials_.on_lanes()) {
        const reliability::TrialTests clean = reliability::GrossErrorTrials::tests_of(without, t),
                                      wrong = reliability::GrossErrorTrials::tests_of(with, t);
        converged = clean.converged && wrong.converged;
        std::optional<reliability::ParityModel> own;
        if (converged)
          shares(kept++, 0) = count(clean, wrong, tally.counts, [&](SnoopingStrategy strategy) {
            if (strategy == SnoopingStrategy::single) return suspected(wrong.suspects);
            if (!own) own = trials_.adjusted(trials_.readings(trial, true)).parity;
            return snoop(strategy, *own);
          });
      } else if (shots && trials_.converged_shots(without, t) && trials_.converged_shots(with, t)) {
        converged = true;
        bool begun = false;
        shares(kept++, 0) = count(trials_.tests_of_shots(without, t), trials_.tests_of_shots(with, t), tally.counts,
                                  [&](SnoopingStrategy strategy) {
                                    if (!begun) trials_.model_of_shots(with, t, family.begin());
                                    begun = true;
                                    if (strategy != SnoopingStrategy::single) return snoop(strategy, family);
                                    return suspected(reliability::data_snooping(family, 0).rejected.front());
                                  });
      } else {
        const reliability::StationAdjustment clean = trials_.adjusted(trials_.readings(trial, false)),
                                             wrong = trials_.adjusted(trials_.readings(trial, true));
        converged = clean.converged && wrong.converged;
        if (converged) {
          const reliability::TrialTests tests = reliability::GrossErrorTrials::tests_of(wrong);
          shares(kept++, 0) = count(
              reliability::GrossErrorTrials::tests_of(clean), tests, tally.counts, [&](SnoopingStrategy strategy) {
                return strategy == SnoopingStrategy::single ? suspected(tests.suspects) : snoop(strategy, wrong.parity);
              });
        }
      }
      if (converged) continue;
      tally.add_failed(trial);
    }
    tally.moments = stats::Moments::of(shares.topRows(kept));
    stop_.keep(block, tally);
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions&) const override {
    study::PointResult r;
    r.tables = {detection_table(s_, prediction_, stop_, tally), injected_table(s_, prediction_),
                compare::failed_trials_table("trials without a converged adjustment", tally.failed_trials)};
    if (stop_.is_on()) r.tables.push_back(stop_.looks_table(tally));
    return r;
  }

  /// By the general adjustment, which agrees with the lanes to rounding.
  std::string replay(std::uint64_t trial) const override {
    std::string text = fmt::format("trial {}\n", trial);
    for (const bool with_errors : {false, true}) {
      const reliability::StationReadings y = trials_.readings(trial, with_errors);
      const reliability::StationAdjustment a = trials_.adjusted(y);
      text += fmt::format("{} errors: {} after {} steps, Omega {:.12g}\n", with_errors ? "with the" : "without",
                          a.converged ? "converged" : "NOT converged", a.iterations, a.omega);
      const Eigen::VectorXd w = a.converged ? reliability::w_statistics(a.parity) : Eigen::VectorXd();
      Eigen::Index n = 0;
      const auto w_of_next = [&] { return n < w.size() ? fmt::format(", w {:.6f}\n", w[n++]) : std::string("\n"); };
      for (std::size_t k = 0; k < y.readings.size(); ++k)
        for (std::size_t i = 0; i < reliability::kReadings; ++i)
          text += fmt::format("  station {} {:<3} {:.12g} {}{}", k, reliability::observation_names()[i],
                              y.readings[k][i], reliability::observation_unit(i), w_of_next());
      for (std::size_t i = reliability::kReadings; i < reliability::kObservations; ++i)  // mse_fixed: without a test
        text += fmt::format("  {} {:.12g} {}{}", reliability::observation_names()[i],
                            y.references[i - reliability::kReadings] * reliability::observation_scale(i),
                            reliability::observation_unit(i), w_of_next());
      for (int term = 0; n < w.size(); ++term) text += fmt::format("  systematic_term_{} 0{}", term, w_of_next());
      if (!with_errors || !a.converged) continue;
      const reliability::TrialTests tests = reliability::GrossErrorTrials::tests_of(a);
      for (const SnoopingStrategy strategy : s_.strategies) {
        const reliability::SnoopingResult r = !rejects(tests)                        ? reliability::SnoopingResult{}
                                              : strategy == SnoopingStrategy::single ? suspected(tests.suspects)
                                                                                     : snoop(strategy, a.parity);
        text += fmt::format("  {}: {}\n", strategy_names()[static_cast<std::size_t>(strategy)],
                            outcome_names()[static_cast<std::size_t>(judge_snooping(r, errors_))]);
      }
    }
    return text;
  }

 private:
  /// |w|, or Pope's |tau|.
  double statistic(const reliability::TrialTests& t, double w) const {
    return s_.pope ? std::abs(w) * std::sqrt(prediction_.redundancy / t.omega) : std::abs(w);
  }
  bool rejects(const reliability::TrialTests& t) const { return statistic(t, t.largest) > prediction_.critical; }

  static reliability::SnoopingResult suspected(const reliability::SuspectGroup& group) {
    reliability::SnoopingResult r;
    r.rejected = {group};
    return r;
  }

  /// A strategy other than `single`. Model: ParityModel or RedundancyFamily.
  template <class Model>
  reliability::SnoopingResult snoop(SnoopingStrategy strategy, Model& model) const {
    if (strategy == SnoopingStrategy::iterative) return reliability::iterative_snooping(model, prediction_.critical);
    if (strategy == SnoopingStrategy::readmission)
      return reliability::iterative_snooping_with_readmission(model, prediction_.critical);
    return reliability::pair_search(model, prediction_.critical);
  }

  /// Counts what happened in a trial; returns the share of tests that raised a false alarm. `search(strategy)` is
  /// called where the largest test with errors rejects.
  template <class Search>
  double count(const reliability::TrialTests& clean, const reliability::TrialTests& wrong,
               std::vector<std::uint64_t>& counts, const Search& search) const {
    const double critical = prediction_.critical;
    for (std::size_t k = 0; k < errors_.size(); ++k) {
      counts[layout_.false_alarm(k)] += statistic(clean, clean.w[errors_[k]]) > critical;
      counts[layout_.detection(k)] += statistic(wrong, wrong.w[errors_[k]]) > critical;
    }
    counts[layout_.false_alarm_any()] += rejects(clean);
    counts[layout_.detection_any()] += rejects(wrong);
    counts[layout_.false_alarm_general()] += clean.omega > prediction_.general.critical;
    counts[layout_.detection_general()] += wrong.omega > prediction_.general.critical;

    for (std::size_t k = 0; k < s_.strategies.size(); ++k) {
      const reliability::SnoopingResult r = rejects(wrong) ? search(s_.strategies[k]) : reliability::SnoopingResult{};
      ++counts[layout_.outcome(k, static_cast<std::size_t>(judge_snooping(r, errors_)))];
    }

    int tested = 0, alarms = 0;
    for (const double w : clean.w) {
      tested += w != 0;
      alarms += w != 0 && statistic(clean, w) > critical;
    }
    return tested > 0 ? static_cast<double>(alarms) / tested : 0;
  }

  Scenario s_;
  reliability::GrossErrorTrials trials_;
  analysis::GrossErrorPrediction prediction_;
  EventLayout layout_;
  compare::VerdictStop stop_;
  Numbers errors_;
};

class GrossErrorPlan final : public study::PlanOf<Scenario> {
 public:
  using PlanOf::PlanOf;
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    require_redundancy(s_);
    Scenario s = with_sizes(s_);
    reliability::GrossErrorTrials trials(s.model, s.attitudes, s.errors(), random::stream_of(s.seed));
    analysis::GrossErrorPrediction prediction = analysis::predict_gross_errors(trials, s.levels, s.pope);
    return std::make_unique<GrossErrorDetection>(std::move(s), std::move(trials), std::move(prediction));
  }
};

}  // namespace

study::Experiment experiment() {
  study::Experiment e{random::StudyId::gross_error_detection,
                      "Gross errors by Monte Carlo: false alarms, detection, identification by strategy",
                      "E. Nyrnes, T. Torkildsen, H. Nahavandchi, Kart og Plan 65, sections 2.1 and 2.2",
                      [](config::ConfigReader& config, random::StudySeed seed) -> std::unique_ptr<study::PointPlan> {
                        Scenario s = read_scenario(config, seed);
                        if (!s.events.empty())
                          return events::event_plan(s.event_run, s.annotations, random::stream_of(s.seed), [s] {
                            require_redundancy(s);
                            return events_of(with_sizes(s));
                          });
                        return std::make_unique<GrossErrorPlan>(std::move(s));
                      }};
  e.approximations = {"form", "independent", "bonferroni"};
  return e;
}

}  // namespace surveymc::studies::gross_error_detection
