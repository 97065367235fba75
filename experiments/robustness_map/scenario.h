#pragma once
/// The checked settings of a config of `robustness_map`.
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "compare/verdict.h"
#include "multistation/fit.h"
#include "multistation/loss.h"
#include "propagate/code_draws.h"
#include "random/study_id.h"
#include "sensor/gross_stations.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::studies::robustness_map {

struct Scenario {
  random::StudySeed seed;
  std::uint64_t trials = 0;
  survey::ReferenceField field;
  survey::Survey well;  ///< the first station is the tie-on
  propagate::CodeDraws draws;
  double noise = 0;  ///< nT, of a magnetometer reading
  sensor::GrossStations gross;
  multistation::FitOptions fit;
  std::vector<multistation::Loss> losses;  ///< least squares first
  compare::VerdictRule verdict;
  compare::Annotations annotations;

  int stations() const { return static_cast<int>(well.size()) - 1; }  ///< that are measured
};

/// Throws InputError.
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

}  // namespace surveymc::studies::robustness_map
