#include "experiments.h"

namespace surveymc {

std::vector<Experiment> all_experiments() {
  return {msa_position_experiment(),        msa_benefit_experiment(),      estimate_experiment(),
          position_covariance_experiment(), vertical_well_experiment(),    sensor_monte_carlo_experiment(),
          reliability_map_experiment(),     reliability_well_experiment(), gross_error_detection_experiment(),
          drift_monitoring_experiment(),    mwd_drift_experiment(),        axial_correction_experiment(),
          chained_multistation_experiment()};
}

}  // namespace surveymc
