#pragma once
/// `estimator.parameters`, `estimator.robust`, `estimator.priors`, `estimator.reference`: the keys of multi-station
/// analysis with any parameters of the table, the same in all studies that have them.
#include <optional>
#include <string>
#include <vector>

#include "analysis/multistation_trials.h"
#include "analysis/robust_limits.h"
#include "compare/warnings.h"
#include "config/config.h"
#include "multistation/robust.h"
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

/// What `estimator.parameters` says: a set, or one of the words that a study has besides.
struct AskedParameters {
  std::optional<multistation::ParameterSet> set;
  std::string word;  ///< where there is no set
};
/// The key must be there. Throws InputError.
AskedParameters read_parameters(config::ConfigReader& config, const std::vector<std::string>& words = {});

/// Whether the config asks for this estimator: not without `estimator.parameters`, and not with "6" and no
/// `estimator.robust`, which is the estimator without the key (read_estimator()). Throws InputError where there is a
/// loss without parameters.
bool wants_parameter_set(config::ConfigReader& config);

/// Refuses keys of other estimators than this one, each with the way out.
void refuse_beside_parameters(config::ConfigReader& config, const std::vector<std::string>& keys);

/// What `estimator.robust = { loss, start }` says; without it least squares.
struct AskedLoss {
  multistation::Loss loss = multistation::Loss::least_squares;
  multistation::RobustStart start = multistation::RobustStart::least_squares;
};
AskedLoss read_loss(config::ConfigReader& config);

/// `estimator.reference = { gravity_mps2, total_nT, dip_deg }`: one sd that an estimator assumes of the reference; what
/// is not given is that of `fallback`.
multistation::ReferenceErrors read_reference_errors(config::ConfigReader& config,
                                                    const multistation::ReferenceErrors& fallback);

/// `estimator.priors.NAME`: one standard deviation of each parameter of the table about 0; without the key that of
/// `fallback`.
multistation::PerParameter<double> read_priors(config::ConfigReader& config,
                                               const multistation::PerParameter<double>& fallback);

/// An estimator of a simulation.
struct SetEstimator {
  multistation::FitOptions fit;
  multistation::RobustOptions robust;  ///< of loss least_squares where none is asked for

  multistation::LossCost cost() const { return multistation::loss_cost(robust.loss, multistation::fit_plan(fit)); }
};

/// The estimator of such a config: `[estimator] name ("msa": the reference taken as it is, a consider parameter;
/// "msa_joint": estimated with it), parameters, robust, priors.NAME, magnetometer_nT, accelerometer_mps2, reference,
/// max_iterations`. Sizes that it does not name are those of the simulation. Throws InputError: with a robust loss
/// stations must have errors of their own (`truth.magnetometer`).
SetEstimator read_parameter_set(config::ConfigReader& config, const AssumedSizes& truth,
                                const survey::ReferenceField& field);

/// What to know of the first order of a robust loss where it is beyond its limits.
std::vector<compare::Warning> warn_of_limits(const analysis::RobustLimits& limits);

/// Tools that differ from run to run: `sensor.spread.parameters.NAME`, one sd of each parameter of the table. Without
/// it the prior of a parameter of the set, and 0 of the others; magnetometers' biases and scales are those of
/// `sensor.spread` where that has any.
multistation::PerParameter<double> read_tool_sd(config::ConfigReader& config,
                                                const multistation::FitOptions& estimator);

/// Noise and errors of the reference that trials draw: those of `noise`, and `noise.reference.gravity_mps2` (0). The
/// run has no stations yet. Throws InputError where the noise is not Gaussian.
analysis::MultistationRun multistation_sizes(config::ConfigReader& config, const sensor::NoiseModel& noise);

}  // namespace surveymc::scenario
