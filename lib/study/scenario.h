#pragma once
/// From a config's text to checked values in SI units: the tables that several studies share.
#include <cstdint>

#include "config/config.h"
#include "config/survey_csv.h"
#include "estimate/estimator.h"
#include "sensor/magnetometer.h"
#include "sensor/tool_spread.h"
#include "study/verdict.h"
#include "survey/reference_field.h"

namespace surveymc::study {

/// `[field] total_nT, dip_deg, declination_deg (0), convergence_deg (0), gravity_mps2 (9.80665)`.
survey::ReferenceField read_field(config::ConfigReader& config);

/// `[survey] file, toolface_zero ("y" where toolface is not needed), azimuth_reference ("true")`.
survey::Survey read_survey(config::ConfigReader& config, const survey::ReferenceField& field, bool needs_toolface);

/// True vertical depth of every station of `survey`, read from the same file, m: as listed there (`tvd_m`, `tvd_ft`),
/// or else by minimum curvature, that of the first station being its measured depth.
std::vector<double> read_true_vertical_depths(config::ConfigReader& config, const survey::Survey& survey);

/// `[sensor] gain (1, 1, 1), bias_nT (0, 0, 0)`.
sensor::MagnetometerErrors read_magnetometer_errors(config::ConfigReader& config);

/// `[noise] magnetometer_nT, accelerometer_mps2 (0), scale (1), law ("gaussian"), reference ({ per = "none" })`.
/// `scale` multiplies every size, so that a sweep over it tells first-order from higher-order effects.
sensor::NoiseModel read_noise(config::ConfigReader& config);

/// `[sensor.spread] gain (0), bias_nT (0), axial_bias_nT (0)`: true errors drawn for every run about the nominal ones;
/// axial_bias_nT adds to the bias of z only.
sensor::ToolSpread read_tool_spread(config::ConfigReader& config);

/// `estimator = "msa"` or `[estimator] name, solver, max_iterations, step_tolerance`; `derivative` of those that have
/// it; and what all that weigh assume, by default what is true of the simulation (`noise`, and `spread` for the
/// priors): magnetometer_nT, accelerometer_mps2, `reference = { total_nT, dip_deg }`, `prior = { gain, bias_nT,
/// axial_bias_nT }` (0: no prior). One sd each. An estimator without a prediction to first order is refused: every
/// study that reads one compares with it.
estimate::EstimatorOptions read_estimator(config::ConfigReader& config, const estimate::InputErrors& truth,
                                          const survey::ReferenceField& field);

/// `estimator.magnetometer_drawn` ("constant"), of wls only: whether what it assumes of a reading is drawn anew in each
/// run, as "sd" or as "variance".
sensor::AssumedNoise read_assumed_noise(config::ConfigReader& config, const std::string& estimator);

/// `[verdict] margin (0.02), confidence (0.95), nees_margin (0.06)`.
VerdictRule read_verdict_rule(config::ConfigReader& config);

/// How many trials: a number, or until the intervals are narrow enough.
struct TrialPlan {
  std::uint64_t trials = 0;  ///< at most
  double relative_ci = 0;    ///< stop when the half width of every interval is below this part of its estimate
  std::vector<std::string> quantities;
  std::vector<std::uint64_t> looks;  ///< trial counts at which to look; empty without [stop]
};

/// `trials` (at least two), or `[stop] relative_ci, quantities, max_trials` with quantities from `stoppable`.
///
/// The rule is valid under repeated looks: looks are fixed beforehand (4096 trials, then 1.5 times more each, up to
/// max_trials), and with J of them every interval is made at confidence 1 - (1 - confidence) / J, which is written to
/// `verdict`. By Bonferroni all of them hold together, so whichever the run stops at holds too.
TrialPlan read_trial_plan(config::ConfigReader& config, const std::vector<std::string>& stoppable,
                          VerdictRule& verdict);

}  // namespace surveymc::study
