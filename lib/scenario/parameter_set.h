#pragma once
/// `estimator.parameters`: multi-station analysis with other parameters than the six gains and biases.
#include "analysis/multistation_trials.h"
#include "config/config.h"
#include "multistation/fit.h"
#include "sensor/magnetometer.h"
#include "survey/reference_field.h"

namespace surveymc::scenario {

/// One standard deviation of everything that a simulation draws, in the place of which an estimator's assumptions
/// stand.
struct AssumedSizes {
  double accelerometer = 0, magnetometer = 0;  ///< m/s2, nT
  multistation::ReferenceErrors reference;
  multistation::PerParameter<double> prior_sd = multistation::default_priors();
};

/// Whether `estimator.parameters` asks for other parameters than the six gains and biases: not without the key, and not
/// with "6", which is the estimator without it (read_estimator()).
bool wants_parameter_set(config::ConfigReader& config);

/// `estimator.priors.NAME`: one standard deviation of each parameter of the table about 0; without the key that of
/// `fallback`.
multistation::PerParameter<double> read_priors(config::ConfigReader& config,
                                               const multistation::PerParameter<double>& fallback);

/// The estimator of such a config: `[estimator] name ("msa": the reference taken as it is, a consider parameter;
/// "msa_joint": estimated with it), parameters, priors.NAME, magnetometer_nT, accelerometer_mps2, reference = {
/// gravity_mps2, total_nT, dip_deg }, max_iterations`. Sizes that it does not name are those of the simulation.
multistation::FitOptions read_parameter_set(config::ConfigReader& config, const AssumedSizes& truth,
                                            const survey::ReferenceField& field);

/// Tools that differ from run to run: `sensor.spread.parameters.NAME`, one sd of each parameter of the table. Without
/// it the prior of a parameter of the set, and 0 of the others; magnetometers' biases and scales are those of
/// `sensor.spread` where that has any.
multistation::PerParameter<double> read_tool_sd(config::ConfigReader& config,
                                                const multistation::FitOptions& estimator);

/// Noise and errors of the reference that trials draw: those of `noise`, and `noise.reference.gravity_mps2` (0). The
/// run has no stations yet. Throws InputError where the noise is not Gaussian.
analysis::MultistationRun multistation_sizes(config::ConfigReader& config, const sensor::NoiseModel& noise);

}  // namespace surveymc::scenario
