#include "registry.h"

// One line a study: its folder, and the function there that says what it is. In the order of `surveymc list`.
#define SURVEYMC_STUDIES(line)                                                                                       \
  line(msa_position, experiment) line(msa_benefit, experiment) line(estimate, experiment)                            \
      line(position_covariance, experiment) line(tool_code_map, experiment) line(vertical_well, experiment)          \
          line(sensor_monte_carlo, experiment) line(reliability, map_experiment) line(reliability, well_experiment)  \
              line(gross_error_detection, experiment) line(drift_monitoring, experiment) line(mwd_drift, experiment) \
                  line(axial_correction, experiment) line(chained_multistation, experiment)

namespace surveymc::studies {

#define SURVEYMC_DECLARE(folder, function) \
  namespace folder {                       \
  study::Experiment function();            \
  }
SURVEYMC_STUDIES(SURVEYMC_DECLARE)
#undef SURVEYMC_DECLARE

std::vector<study::Experiment> all_experiments() {
#define SURVEYMC_CALL(folder, function) folder::function(),
  return {SURVEYMC_STUDIES(SURVEYMC_CALL)};
#undef SURVEYMC_CALL
}

}  // namespace surveymc::studies
