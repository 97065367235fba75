#pragma once
/// `msa_benefit` with other parameters than six gains and biases (`estimator.parameters`): maps over directions of what
/// a run can tell of them, and of what the correction does to the position. First order alone.
#include <memory>
#include <optional>
#include <vector>

#include "analysis/multistation_trials.h"
#include "analysis/well_design.h"
#include "config/config.h"
#include "random/study_id.h"
#include "scenario/parameter_set.h"
#include "study/experiment.h"

namespace surveymc::studies::msa_benefit {

struct SetMapScenario {
  std::vector<double> inclination_deg, azimuth_deg;
  survey::ReferenceField field;
  analysis::WellDesign well;
  analysis::MultistationRun sizes;  ///< of the draws; without stations
  scenario::SetEstimator estimator;
};

/// Nothing where the config asks for the six gains and biases. Throws InputError.
std::optional<SetMapScenario> read_set_maps(config::ConfigReader& config, random::StudySeed seed);

std::unique_ptr<study::PointPlan> set_map_plan(SetMapScenario scenario);

}  // namespace surveymc::studies::msa_benefit
