#include "compare/trial_plan.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "config/meanings.h"
#include "config/suggest.h"
#include "montecarlo/run_blocks.h"
#include "render/text.h"

namespace surveymc::compare {

VerdictRule read_verdict_rule(config::ConfigReader& c) {
  const VerdictRule usual;
  if (c.has("verdict.family"))  // read_run() asks for it, for all points
    c.choice("verdict.family", {"holm", "none"},
             "how verdicts of many rows are judged together, of all points: 'holm' (without the key), or 'none': each "
             "row alone, so that the column `family` is empty and `--check` counts every row");
  return {c.number("verdict.margin", config::Range::open(0, 1), config::meaning::kMargin, usual.margin),
          c.number("verdict.confidence", kConfidences, config::meaning::kConfidence, usual.confidence),
          c.number("verdict.nees_margin", config::Range::open(0, 1), config::meaning::kNeesMargin, usual.nees_margin)};
}

namespace {

/// Trial counts in whole blocks: 4096, then `factor` times more each, at last `most`.
std::vector<std::uint64_t> looks_until(std::uint64_t most, double factor) {
  std::vector<std::uint64_t> looks;
  for (double n = 4096; n < static_cast<double>(most); n *= factor) {
    const std::uint64_t trials = static_cast<std::uint64_t>(n) / montecarlo::kBlockTrials * montecarlo::kBlockTrials;
    if (looks.empty() || trials > looks.back()) looks.push_back(std::min(trials, most));
  }
  looks.push_back(most);
  return looks;
}

/// The rows that `stop.verdict` names, as "table.quantity" or "table.quantity.formulation".
std::vector<Row> read_decisive_rows(config::ConfigReader& c, const std::vector<Row>& judged) {
  std::vector<Row> rows;
  for (const std::string& name : c.texts("stop.verdict",
                                         "end the run when each of these rows agrees or differs: `table.quantity`, or "
                                         "`table.quantity.formulation`")) {
    std::vector<std::string> known, all;
    const std::size_t before = rows.size();
    for (const Row& row : judged) {
      const std::string shorter = row.table + "." + row.quantity,
                        longer = shorter + (row.formulation.empty() ? "" : "." + row.formulation);
      if (name == shorter || name == longer) rows.push_back(row);
      known.push_back(longer);
      all.insert(all.end(), {shorter, longer});
    }
    if (rows.size() == before)
      c.fail("stop.verdict",
             fmt::format("\"{}\" is no row with a margin that trials can decide: must be of {}{}",
                         render::printable(name), fmt::join(known, ", "), config::suggestion(name, all)));
  }
  return rows;
}

}  // namespace

TrialPlan read_trial_plan(config::ConfigReader& c, const std::vector<Row>& rows, VerdictRule& verdict) {
  constexpr std::int64_t kMost = 1'000'000'000'000;
  // A sequence may look as often as it likes: 1.05 instead of 1.1 saves 3 % of the trials.
  constexpr double kClosely = 1.05, kOften = 1.1, kSeldom = 1.5;
  TrialPlan plan;
  if (!c.has("stop")) {
    plan.trials = static_cast<std::uint64_t>(c.integer("trials", 2, kMost, config::meaning::kTrials));
    return plan;
  }
  std::vector<std::string> stoppable;
  std::vector<Row> judged;
  for (const Row& row : rows) {
    if (row.available && row.predicted && !row.calibrated) judged.push_back(row);
    const bool is_known = std::find(stoppable.begin(), stoppable.end(), row.quantity) != stoppable.end();
    if (row.available && row.controlled && !is_known) stoppable.push_back(row.quantity);
  }
  if (c.has("trials")) c.fail("trials", "not together with [stop]: there it is max_trials");
  if (!judged.empty() && c.has("stop.verdict")) {
    for (const char* key : {"stop.relative_ci", "stop.quantities", "stop.correction"})
      if (c.has(key)) c.fail(key, "not together with stop.verdict: a run ends by its intervals or by its verdicts");
    plan.decisive = read_decisive_rows(c, judged);
    plan.trials = static_cast<std::uint64_t>(c.integer("stop.max_trials", 4096, kMost, config::meaning::kMostTrials));
    plan.looks = looks_until(plan.trials, kClosely);
    verdict.at_all_looks = true;
    return plan;
  }
  if (judged.empty() && c.has("stop.verdict"))
    c.fail("stop.verdict", "no row of this study has an interval that holds at all looks: end it by stop.relative_ci");
  if (stoppable.empty() && !c.has("stop.verdict")) c.fail("stop", "this study ends by its verdicts: give stop.verdict");
  plan.relative_ci = c.number("stop.relative_ci", config::Range::open(0, 1),
                              "end the run when the half width of each interval is below this part of the value");
  plan.trials = static_cast<std::uint64_t>(c.integer("stop.max_trials", 4096, kMost, config::meaning::kMostTrials));
  plan.quantities = c.texts("stop.quantities", "quantities whose intervals end the run");
  for (const std::string& q : plan.quantities)
    if (std::find(stoppable.begin(), stoppable.end(), q) == stoppable.end())
      c.fail("stop.quantities", config::none_of(q, stoppable));
  const bool corrected =
      c.choice("stop.correction", {"none", "bonferroni"},
               "'bonferroni': fewer looks, and intervals that hold at all of them", "none") == "bonferroni";
  plan.looks = looks_until(plan.trials, corrected ? kSeldom : kOften);
  if (corrected) verdict.confidence = 1 - (1 - verdict.confidence) / static_cast<double>(plan.looks.size());
  return plan;
}

}  // namespace surveymc::compare
