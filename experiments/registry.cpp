#include "registry.h"

// One line a study: its folder, and the function in it that describes the study. In the order of `surveymc list`.
// clang-format off
#define SURVEYMC_STUDIES(study)            \
  study(msa_position, experiment)          \
  study(msa_benefit, experiment)           \
  study(estimate, experiment)              \
  study(position_covariance, experiment)   \
  study(tool_code_map, experiment)         \
  study(error_model_monte_carlo, experiment) \
  study(clearance, experiment)             \
  study(collision, experiment)             \
  study(rare_event, experiment)            \
  study(vertical_well, experiment)         \
  study(sensor_monte_carlo, experiment)    \
  study(reliability, map_experiment)       \
  study(reliability, well_experiment)      \
  study(gross_error_detection, experiment) \
  study(drift_monitoring, experiment)      \
  study(mwd_drift, experiment)             \
  study(axial_correction, experiment)      \
  study(chained_multistation, experiment)
// clang-format on

namespace surveymc::studies {

#define SURVEYMC_DECLARE(folder, function) \
  namespace folder {                       \
  study::Experiment function();            \
  }
SURVEYMC_STUDIES(SURVEYMC_DECLARE)

std::vector<study::Experiment> all_experiments() {
#define SURVEYMC_CALL(folder, function) folder::function(),
  return {SURVEYMC_STUDIES(SURVEYMC_CALL)};
}

}  // namespace surveymc::studies
