#pragma once
/// The common part of studies of rare events: `[sampling]` of a config, the preparing that it asks for, the trials, the
/// rows of a probability and the tables `sampling` and `design_points`.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/comparison.h"
#include "compare/table_rows.h"
#include "compare/trial_plan.h"
#include "config/config.h"
#include "montecarlo/blocks.h"
#include "rare/event_trials.h"
#include "rare/preparing.h"
#include "rare/subset_simulation.h"
#include "stats/weighted_hits.h"

namespace surveymc::events {

/// `[sampling] method ("auto"), pilot (1000), shares ({ adapted = 0.75, shifted = 0.2, wide = 0.05 }), subset ({
/// samples = 1000, replicates = 10 }), max_components (12)`.
struct EventSampling {
  std::string method = "auto";
  rare::PreparingOptions preparing;
  int subset_samples = 1000;
  int subset_replicates = 10;  ///< of the check; 0: none
};

/// `methods`: allowed besides "auto", "plain", "importance" and "subset". Trials under a proposal are refused where the
/// config has antithetic pairs or a control variate.
EventSampling read_event_sampling(config::ConfigReader& config, const std::vector<std::string>& methods = {});

/// What the config of a run of events says of its trials.
struct EventRun {
  EventSampling sampling;
  compare::VerdictRule verdict;  ///< `verdict.margin` is 0.1 of the ratio unless the config says otherwise
  compare::TrialPlan plan;       ///< of `method = "subset"`: replicates
  std::uint64_t save_samples = 0;
  /// Trials in a block; `usual` unless they are replicates.
  int block_trials(int usual = montecarlo::kBlockTrials) const { return sampling.method == "subset" ? 1 : usual; }
};
EventRun read_event_run(config::ConfigReader& config, const std::vector<std::string>& methods = {});

/// If the design point is nearer than this, plain trials are as good.
inline constexpr double kPlainBeta = 2;

/// One event, ready to be drawn.
struct PreparedEvent {
  std::string method;  ///< resolved: "plain", "importance", "subset", "union"
  rare::Prepared prepared = {};
  std::optional<rare::UnionTrials> of_union = {};
};

/// Resolves "auto", and prepares the proposal where one is needed: `prepare` is called for "auto" and "importance".
PreparedEvent prepare_event(const EventSampling& sampling, const std::function<rare::Prepared()>& prepare);

/// What the tally of an event says.
struct EventEstimate {
  double probability = kNaN;
  stats::Interval interval{kNaN, kNaN};
  stats::WeightedHits hits;
  std::uint64_t evaluations = 0;  ///< of the main run
  double relative_half_width = kNaN, relative_efficiency = kNaN;
  rare::SubsetEstimate check{kNaN, kNaN, kNaN};  ///< subset simulation at the config's confidence
  std::uint64_t check_evaluations = 0;
  bool trusted = false;
  std::string note;
};

/// `check`: the tally of replicates of subset simulation; none of them: no check. Contradicted is an estimate whose
/// interval at 99 % lies below the check's by more than the check's bias of 15 %: a mode may be missing. Less than the
/// estimate is found by few skewed replicates, too, and is only noted.
EventEstimate estimate_event(const PreparedEvent& event, const stats::Tally& tally, const stats::Tally& check,
                             double confidence, int dimension);

/// Trials needed in all until the half width of the interval is `relative_ci` of the estimate; most where nothing is
/// known yet.
std::uint64_t trials_for(const EventEstimate& so_far, std::uint64_t trials, double relative_ci);

/// A row of the table `probability`: a prediction against the estimate. An estimate that is not trusted has no verdict
/// but "undecided", and its note says why.
compare::ComparisonRow compare_probability(const std::string& formulation, const EventEstimate& found, double predicted,
                                           const compare::VerdictRule& rule, std::uint64_t trials);

/// The columns of the table `sampling` of one event.
void put_sampling(compare::TableRows& t, const PreparedEvent& event, const EventEstimate& found);

/// The table `design_points`: one row a component, `component, kind, beta, share_of_hits`; `more` adds the study's own
/// columns of a design point. Without components, no row.
void put_designs(compare::TableRows& t, const PreparedEvent& event, const stats::Tally& tally,
                 const std::function<void(std::size_t design)>& more);

}  // namespace surveymc::events
