#pragma once
/// Tables of a gross-error study.
#include "analysis/gross_error_prediction.h"
#include "gross_error_detection/scenario.h"
#include "montecarlo/run_blocks.h"
#include "stats/layout.h"
#include "store/table.h"

namespace surveymc::studies::gross_error_detection {

/// Outcome of a trial by one strategy.
enum class SnoopingOutcome {
  identified,  ///< the rejected observations are those in error, each of them told from all others
  group,       ///< those in error are in the rejected groups, one each, but a group has other members, or ties
  partly,      ///< some of those in error are rejected, or others with them
  wrong,       ///< only observations without error are rejected
  missed       ///< nothing is rejected
};
inline constexpr std::size_t kOutcomes = 5;

/// Layout of the counts of events in a tally; their order is that of the tables.
struct EventLayout : stats::Layout {
  EventLayout(std::size_t errors, std::size_t snooping) : injected(errors), strategies(snooping) {}
  std::size_t injected, strategies;
  stats::Slots false_alarm = slots(injected), false_alarm_any = slots(), false_alarm_general = slots();
  stats::Slots detection = slots(injected), detection_any = slots(), detection_general = slots();
  stats::Slots outcome = slots(strategies, kOutcomes);  ///< by strategy and SnoopingOutcome
};

/// All rows of table `detection`, which are rates of the events of EventLayout; without `prediction` they have none. Of
/// the outcomes of snooping those alone are predicted that are of a single error, singly looked for.
std::vector<compare::Row> rows_of(const Scenario& s, const analysis::GrossErrorPrediction* prediction = nullptr);
/// Rows of table `detection`, all rates, without annotations.
std::vector<compare::ComparisonRow> detection_rows(const Scenario& s, const analysis::GrossErrorPrediction& p,
                                                   const stats::Tally& tally);
store::Table detection_table(const Scenario& s, const analysis::GrossErrorPrediction& p,
                             const compare::VerdictStop& stop, const stats::Tally& tally);
/// One row per error: size, minimal detectable errors, shifts, and the test most correlated with its own.
store::Table injected_table(const Scenario& s, const analysis::GrossErrorPrediction& p);

}  // namespace surveymc::studies::gross_error_detection
