#include "registry.h"

// One line a study: its folder, and the functions in it that describe the study and say what a result has found. In the
// order of `surveymc list`.
// clang-format off
#define SURVEYMC_STUDIES(study)            \
  study(msa_position, experiment, answer)                           \
  study(msa_benefit, experiment, answer)                            \
  study(estimate, experiment, answer)                               \
  study(position_covariance, experiment, answer)                    \
  study(tool_code_map, experiment, answer)                          \
  study(corrected_codes, experiment, answer)                        \
  study(error_model_monte_carlo, experiment, answer)                \
  study(clearance, experiment, answer)                              \
  study(collision, experiment, answer)                              \
  study(rare_event, experiment, answer)                             \
  study(vertical_well, experiment, answer)                          \
  study(sensor_monte_carlo, experiment, answer)                     \
  study(reliability, map_experiment, map_answer)                    \
  study(reliability, well_experiment, well_answer)                  \
  study(gross_error_detection, experiment, answer)                  \
  study(drift_monitoring, experiment, answer)                       \
  study(mwd_drift, experiment, answer)                              \
  study(axial_correction, experiment, answer)                       \
  study(chained_multistation, experiment, answer)                   \
  study(robustness_map, experiment, answer)
// clang-format on

namespace surveymc::studies {

#define SURVEYMC_DECLARE(folder, describe, say)                   \
  namespace folder {                                              \
  study::Experiment describe();                                   \
  void say(compare::Answer& answer, const store::Result& result); \
  }
SURVEYMC_STUDIES(SURVEYMC_DECLARE)

std::vector<study::Experiment> all_experiments() {
  std::vector<study::Experiment> all;
#define SURVEYMC_ADD(folder, describe, say) \
  all.push_back(folder::describe());        \
  all.back().answer = folder::say;
  SURVEYMC_STUDIES(SURVEYMC_ADD)
  return all;
}

}  // namespace surveymc::studies
