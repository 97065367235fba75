#pragma once
/// Predicted rates of a gross-error study, and its tables.
#include <cmath>

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

/// Shifts of the tests by the injected errors, without noise.
struct ErrorShift {
  std::vector<double> w;  ///< of each injected observation's test; NaN where the adjustment does not converge
  double omega = 0;       ///< noncentrality of the general test
};

/// Everything that the rates are held against.
struct Prediction {
  double two_sided_alpha, critical;     ///< of the single test: |w| or |tau|
  reliability::DimensionLevel general;  ///< B-method: the general test finds nabla_0 with the power of the single test
  double redundancy;
  ErrorShift linear, nonlinear;
  reliability::ParityModel model;         ///< at the error-free readings
  double false_alarm_any = std::nan("");  ///< some test rejects though there is no error, linear theory
  double linear_any = std::nan("");       ///< some test rejects, linear theory
  /// By the shift of the nonlinear adjustment and the tests at its solution; NaN: not known (linear_rates).
  double any = std::nan("");
  double identified = std::nan("");  ///< one error, strategy single
  bool in_group = false;             ///< the observation in error is in a group: `identified` is the group's
};
Prediction predict_gross_errors(const Scenario& s, const reliability::GrossErrorTrials& trials);

/// Comparison table of all rates.
store::Table detection_table(const Scenario& s, const Prediction& p, const stats::Tally& tally);
/// One row per error: size, minimal detectable errors, shifts, and the test that is most like its own.
store::Table injected_table(const Scenario& s, const Prediction& p);

}  // namespace surveymc::studies::gross_error_detection
