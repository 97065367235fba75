#pragma once
/// Every study, by name. A new one adds its function here and to registry.cpp.
#include <vector>

#include "study/experiment.h"

namespace surveymc {

Experiment chained_multistation_experiment();
Experiment msa_benefit_experiment();
Experiment msa_position_experiment();
Experiment position_covariance_experiment();
Experiment estimate_experiment();
Experiment vertical_well_experiment();
Experiment sensor_monte_carlo_experiment();
Experiment reliability_map_experiment();
Experiment reliability_well_experiment();
Experiment gross_error_detection_experiment();
Experiment drift_monitoring_experiment();
Experiment mwd_drift_experiment();
Experiment axial_correction_experiment();

/// All of them, in the order of `surveymc list`.
std::vector<Experiment> all_experiments();

}  // namespace surveymc
