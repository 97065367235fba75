#pragma once
/// The settings of a config of `chained_multistation`, in internal units.
#include <string>
#include <vector>

#include "chained/batch.h"
#include "chained/linearised_station.h"
#include "chained/model.h"
#include "compare/annotations.h"
#include "compare/calibration.h"
#include "compare/trial_plan.h"
#include "compare/verdict.h"
#include "compare/verdict_stop.h"
#include "random/study_id.h"
#include "sensor/chained_runs.h"
#include "study/experiment.h"

namespace surveymc::studies::chained_multistation {

/// How a run is solved. The first two take every station alone.
enum class Solver { base, single, filter, filter_independent, smoother, smoother_independent };
const std::vector<std::string>& solver_names();
inline bool is_chained(Solver e) { return e != Solver::base && e != Solver::single; }
inline chained::ChainReferences references_of(Solver e) {
  return e == Solver::filter_independent || e == Solver::smoother_independent ? chained::ChainReferences::independent
                                                                              : chained::ChainReferences::chained;
}
inline chained::Mode mode_of(Solver e) {
  return e == Solver::filter || e == Solver::filter_independent ? chained::Mode::filter : chained::Mode::smoother;
}

struct Scenario {
  random::StudySeed seed;
  compare::TrialPlan trial_plan;
  survey::ReferenceField field;
  chained::ChainSizes sizes;
  int offset_stations = 18;       ///< n of the expected offsets
  sensor::ChainedRunSetup truth;  ///< profile included
  std::vector<double> md;         ///< m, along the profile
  std::vector<Solver> estimators;
  std::size_t kept_runs = 0;  ///< of study "performance": the first so many, each with its own RMS
  compare::VerdictRule verdict;
  compare::CalibrationRule calibration;  ///< of study "performance"
  compare::Annotations annotations;

  int stations() const { return static_cast<int>(truth.attitudes.size()); }
  chained::Model model(chained::ChainReferences references) const {
    return chained::make_model(sizes, offset_stations, references);
  }
};

/// What a scenario is read for.
enum class Purpose {
  performance,   ///< estimators are compared, some of which observe the references anew at every station
  chained_only,  ///< the references are chained in all solutions
  events         ///< the same, and [verdict] is left to the event
};
/// `[field]`, `[model]`, `[profile]` or `[survey]`, `[verdict]`: all keys but trials and those that one study alone
/// reads.
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed, Purpose purpose);

inline constexpr compare::TrialLimits kTrialLimits{2, 100'000'000};
/// read_scenario() and `trials`, of the studies that have no [stop].
Scenario read_scenario_of_fixed_length(config::ConfigReader& config, random::StudySeed seed);

}  // namespace surveymc::studies::chained_multistation
