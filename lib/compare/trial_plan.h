#pragma once
/// Reads how trials are judged (`[verdict]`) and how many there are (`trials` or `[stop]`).
#include <cstdint>
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "compare/verdict.h"
#include "config/config.h"

namespace surveymc::compare {

/// Allowed confidences of intervals. Nearer to 0 or 1 the quantiles are no numbers any more.
inline const config::Range kConfidences = config::Range::closed(1e-9, 1 - 1e-9);

/// `[verdict] margin (0.02), confidence (0.95), nees_margin (0.06)`.
VerdictRule read_verdict_rule(config::ConfigReader& config);

/// The number of trials: given, or as many as make the intervals narrow enough.
struct TrialPlan {
  std::uint64_t trials = 0;  ///< at most
  double relative_ci = 0;    ///< stop when the half width of every interval is below this part of its estimate
  std::vector<std::string> quantities;
  std::vector<Row> decisive;         ///< stop when each of these rows is decided; then there is no relative_ci
  std::vector<std::uint64_t> looks;  ///< trial counts at which to look; empty without [stop]
};

/// `trials` (at least two), or one of two kinds of `[stop]`, whose looks are 4096 trials and then 1.1 (by verdict 1.05)
/// times more each, up to `max_trials`.
///
/// By precision, `relative_ci, quantities` (those of controlled rows), `correction ("none")`: the moment of the stop
/// depends on the width of an interval, not on where it lies, and so the interval of a fixed number of trials keeps its
/// coverage (Chow and Robbins 1965). "bonferroni" looks every 1.5 times, J times in all, and makes every interval at 1
/// - (1 - confidence) / J, which is written to `verdict`.
///
/// By verdict, `verdict` (names of predicted rows): the moment depends on the value. Intervals are those of a
/// confidence sequence (stats/confidence_sequence.h), valid at all looks at once: verdict.at_all_looks is set. Without
/// a predicted row a study has no such stop. Of `rows` those count that are available.
TrialPlan read_trial_plan(config::ConfigReader& config, const std::vector<Row>& rows, VerdictRule& verdict);

}  // namespace surveymc::compare
