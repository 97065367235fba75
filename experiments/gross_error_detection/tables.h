#pragma once
/// Tables of a gross-error study.
#include "analysis/gross_error_prediction.h"
#include "gross_error_detection/scenario.h"
#include "montecarlo/run_blocks.h"
#include "stats/layout.h"
#include "store/table.h"

namespace surveymc::studies::gross_error_detection {

/// What becomes of a trial by one strategy.
enum class SnoopingOutcome {
  identified,  ///< the rejected observations are those in error, each of them told from all others
  group,       ///< they are among the rejected groups, one each, but at least one group has other members, or ties
  partly,      ///< some are rejected, or others with them
  wrong,       ///< only others are rejected
  missed       ///< nothing is rejected
};
inline constexpr std::size_t kOutcomes = 5;

/// Where events are counted in a tally; the order of counting is that of the tables.
struct EventLayout : stats::Layout {
  EventLayout(std::size_t errors, std::size_t snooping) : injected(errors), strategies(snooping) {}
  std::size_t injected, strategies;
  stats::Slots false_alarm = slots(injected), false_alarm_any = slots(), false_alarm_general = slots();
  stats::Slots detection = slots(injected), detection_any = slots(), detection_general = slots();
  stats::Slots outcome = slots(strategies, kOutcomes);  ///< by strategy and SnoopingOutcome
};

/// Comparison table of all rates.
store::Table detection_table(const Scenario& s, const analysis::GrossErrorPrediction& p, const stats::Tally& tally);
/// One row per error: size, minimal detectable errors, shifts, and the test that is most like its own.
store::Table injected_table(const Scenario& s, const analysis::GrossErrorPrediction& p);

}  // namespace surveymc::studies::gross_error_detection
