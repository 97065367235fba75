#pragma once
/// From a config's text to checked values in SI units: the tables that several studies share.
#include <cstdint>

#include "config/config.h"
#include "config/survey_csv.h"
#include "estimate/estimator.h"
#include "field/reference_field.h"
#include "sensor/magnetometer.h"
#include "study/verdict.h"

namespace surveymc {

/// `[field] total_nT, dip_deg, declination_deg (0), convergence_deg (0), gravity_mps2 (9.80665)`.
ReferenceField read_field(ConfigReader& config);

/// `[survey] file, toolface_zero, azimuth_reference ("true")`.
Survey read_survey(ConfigReader& config, const ReferenceField& field, bool needs_toolface);

/// `[sensor] gain (1, 1, 1), bias_nT (0, 0, 0)`.
MagnetometerErrors read_magnetometer_errors(ConfigReader& config);

/// `[noise] magnetometer_nT, accelerometer_mps2 (0), scale (1), law ("gaussian"), reference ({ per = "none" })`.
/// `scale` multiplies every size, so that a sweep over it tells first-order from higher-order effects.
NoiseModel read_noise(ConfigReader& config);

/// `estimator = "msa"` or `[estimator] name, solver, max_iterations, step_tolerance`.
EstimatorOptions read_estimator(ConfigReader& config);

/// `[verdict] margin (0.02), confidence (0.95)`.
VerdictRule read_verdict_rule(ConfigReader& config);

/// `trials`, at least two: a variance needs them.
std::uint64_t read_trials(ConfigReader& config);

}  // namespace surveymc
