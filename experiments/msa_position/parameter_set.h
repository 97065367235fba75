#pragma once
/// `msa_position` with other parameters than six gains and biases (`estimator.parameters`): the same question for any
/// of the 21 constant errors of both triads.
#include <memory>
#include <optional>

#include "analysis/multistation_prediction.h"
#include "compare/verdict_stop.h"
#include "config/config.h"
#include "random/study_id.h"
#include "scenario/parameter_set.h"
#include "study/experiment.h"

namespace surveymc::studies::msa_position {

struct SetScenario {
  random::StudySeed seed;
  compare::TrialPlan trial_plan;
  survey::Survey survey;
  config::ConfigPlace survey_place;  ///< of its file
  analysis::MultistationRun run;
  scenario::SetEstimator estimator;
  compare::VerdictRule verdict;
  compare::Annotations annotations;
};

/// Nothing where the config asks for the six gains and biases. Throws InputError.
std::optional<SetScenario> read_set_scenario(config::ConfigReader& config, random::StudySeed seed);

std::unique_ptr<study::PointPlan> set_plan(SetScenario scenario);

}  // namespace surveymc::studies::msa_position
