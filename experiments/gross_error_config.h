#pragma once
/// What a config of `gross_error_detection` says, checked; and the names of the rows that follow from it.
#include <cstdint>
#include <string>
#include <vector>

#include "config/config.h"
#include "reliability/gross_error_trials.h"
#include "reliability/significance.h"
#include "study/annotations.h"
#include "study/verdict.h"

namespace surveymc {

/// `single`: one rejection at most; the others are those of reliability/snooping.h.
enum class SnoopingStrategy { single, iterative, readmission, pairs };
/// "single", "iterative", "readmission", "pairs".
const std::vector<std::string>& strategy_names();

/// One error of `[[inject]]`.
struct InjectedError {
  std::string label;        ///< "bx"; with several stations "bx_2" for station 2, references without a number
  std::size_t observation;  ///< in the order of Observation
  std::size_t station;
  GrossError error;  ///< its number in the adjustment, and its size in internal units
};

struct GrossErrorScenario {
  std::uint64_t seed = 0, trials = 0;
  AdjustmentModel model;
  TestLevels levels;
  std::vector<Attitude> attitudes;  ///< of the stations; azimuths magnetic
  std::vector<InjectedError> injected;
  bool pope = false;  ///< Pope's test (variance unknown) instead of the w-test
  std::vector<SnoopingStrategy> strategies;
  VerdictRule verdict;
  double false_alarm_margin = 0.1;  ///< in place of verdict.margin for rates of false alarms
  Annotations annotations;

  std::vector<GrossError> errors() const;
};

/// Names of what becomes of a trial by each strategy, in the order of SnoopingOutcome.
const std::vector<std::string>& outcome_names();

GrossErrorScenario read_gross_error_scenario(ConfigReader& config, std::uint64_t seed);

}  // namespace surveymc
