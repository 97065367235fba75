#pragma once
/// What a config of `chained_multistation` says, in internal units.
#include <string>
#include <vector>

#include "estimate/chained_batch.h"
#include "estimate/chained_linear.h"
#include "estimate/chained_model.h"
#include "random/study_id.h"
#include "sensor/chained_runs.h"
#include "study/annotations.h"
#include "study/experiment.h"
#include "study/scenario.h"
#include "study/verdict.h"

namespace surveymc {

/// How a run is solved. The first two take every station alone.
enum class ChainedEstimator { base, single, filter, filter_independent, smoother, smoother_independent };
const std::vector<std::string>& chained_estimator_names();
inline bool is_chained(ChainedEstimator e) { return e != ChainedEstimator::base && e != ChainedEstimator::single; }
inline ChainReferences references_of(ChainedEstimator e) {
  return e == ChainedEstimator::filter_independent || e == ChainedEstimator::smoother_independent
             ? ChainReferences::independent
             : ChainReferences::chained;
}
inline ChainedMode mode_of(ChainedEstimator e) {
  return e == ChainedEstimator::filter || e == ChainedEstimator::filter_independent ? ChainedMode::filter
                                                                                    : ChainedMode::smoother;
}

struct ChainedScenario {
  StudySeed seed;
  std::uint64_t trials = 0;
  ReferenceField field;
  ChainSizes sizes;
  int offset_stations = 18;  ///< n of the expected offsets
  ChainedRunSetup truth;     ///< profile included
  std::vector<double> md;    ///< m, along the profile
  std::vector<ChainedEstimator> estimators;
  VerdictRule verdict;
  Annotations annotations;

  int stations() const { return static_cast<int>(truth.attitudes.size()); }
  ChainedModel model(ChainReferences references) const { return chained_model(sizes, offset_stations, references); }
};

/// `[field]`, `[model]`, `[profile]` or `[survey]`, trials, `[verdict]`: all but what one study alone reads.
ChainedScenario read_chained_scenario(ConfigReader& config, StudySeed seed);

}  // namespace surveymc
