#pragma once
/// The checked settings of a config of `gross_error_detection`, and the names of the rows that follow from them.
#include <cstdint>
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "compare/verdict.h"
#include "compare/verdict_stop.h"
#include "config/config.h"
#include "events/event_study.h"
#include "random/study_id.h"
#include "reliability/gross_error_trials.h"
#include "reliability/significance.h"

namespace surveymc::studies::gross_error_detection {

/// `single`: one rejection at most; the others are those of reliability/snooping.h.
enum class SnoopingStrategy { single, iterative, readmission, pairs };
/// "single", "iterative", "readmission", "pairs".
const std::vector<std::string>& strategy_names();

/// One error of `[[inject]]`.
struct InjectedError {
  std::string label;            ///< "bx"; with several stations "bx_2" for station 2, references without a number
  std::size_t observation = 0;  ///< in the order of Observation
  std::size_t station = 0;
  reliability::GrossError
      error;  ///< its number in the adjustment, and its size in internal units: of others than `given` 1

  enum class Size { given, minimal_detectable, nonlinear_detectable, nonlinear_own_test } size = Size::given;
  double factor = 1;          ///< of a detectable size
  config::ConfigPlace place;  ///< of a detectable size
};

struct Scenario {
  random::StudySeed seed;
  compare::TrialPlan trial_plan;
  reliability::AdjustmentModel model;
  config::ConfigPlace noise_place;  ///< of the noise that is smaller beside its default
  reliability::TestLevels levels;
  std::vector<survey::Attitude> attitudes;  ///< of the stations; azimuths magnetic
  std::vector<InjectedError> injected;
  bool pope = false;  ///< Pope's test (variance unknown) instead of the w-test
  std::vector<SnoopingStrategy> strategies;
  compare::VerdictRule verdict;
  double false_alarm_margin = 0.1;  ///< in place of verdict.margin for rates of false alarms
  compare::Annotations annotations;
  std::vector<events::EventRule> events;  ///< not empty: the run is one of events
  events::EventRun event_run;

  std::vector<reliability::GrossError> errors() const;
};

/// Names of the outcomes of a trial by each strategy, in the order of SnoopingOutcome.
const std::vector<std::string>& outcome_names();

/// Reads the scenario without the sizes that have to be computed. Throws InputError.
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

/// Throws InputError where the misclosures have no covariance that can be inverted: one noise is too small beside the
/// other errors.
void require_redundancy(const Scenario& scenario);

/// The scenario with the sizes of all errors. Throws InputError where a detectable error is infinite.
Scenario with_sizes(Scenario scenario);

/// Where the config has `[[event]]`: its events, of a scenario with sizes. Predictions: linear and nonlinear theory
/// where they are good enough, the error's own test alone, and of false alarms those of independent tests and the sum
/// of all.
std::vector<events::TrialEvent> events_of(const Scenario& scenario);

}  // namespace surveymc::studies::gross_error_detection
