#pragma once
/// From a config's text to checked values in SI units: the tables that several studies share.
#include <cstdint>

#include "config/config.h"
#include "config/survey_csv.h"
#include "estimate/estimator.h"
#include "scenario/reference_field.h"
#include "sensor/magnetometer.h"
#include "sensor/tool_spread.h"
#include "survey/reference_field.h"

namespace surveymc::scenario {

/// `[survey] file, toolface_zero ("y" where not needed), azimuth_reference (what the file says, or "true")`; or a well
/// by `[survey.plan]`, without toolfaces. The file may be of another program (foreign_table.h); `depth_unit,
/// angle_unit, decimal, columns, skip_lines, sheet, trajectory, encoding` say what it leaves open.
survey::Survey read_survey(config::ConfigReader& config, const survey::ReferenceField& field, bool needs_toolface);

/// From which north a survey file's azimuths are: what its column says, or else `key` ("true"). The key must not
/// contradict the file, and must be there where the file says that it does not know.
config::AzimuthReference read_azimuth_reference(config::ConfigReader& config, const config::InputTable& table,
                                                const std::string& key);
/// Warns where azimuths from grid or magnetic north would be turned to true north by an angle of exactly 0, which a
/// config has that says nothing of it. The same for a survey in our own form and in another one.
void warn_of_north(config::ConfigReader& config, const config::InputTable& table,
                   const config::SurveyConventions& conventions);

/// The file that `file` of an [[offset]] names, in our own form or that of another program: with the keys of `[survey]`
/// for what such a file leaves open.
config::InputTable read_offset_table(config::ConfigReader& offset);

/// The file that `readings` names, in our own form or that of another program.
config::InputTable read_readings_table(config::ConfigReader& config);

/// True vertical depth of every station of `survey`, read from the same file, m: as listed there (`tvd_m`, `tvd_ft`),
/// or else by minimum curvature, that of the first station being its measured depth.
std::vector<double> read_true_vertical_depths(config::ConfigReader& config, const survey::Survey& survey);

/// `[sensor] gain (1, 1, 1), bias_nT (0, 0, 0)`.
sensor::MagnetometerErrors read_magnetometer_errors(config::ConfigReader& config);

/// `[noise] magnetometer_nT, accelerometer_mps2 (0), scale (1), law ("gaussian"), reference ({ per = "none" })`, or
/// `reference = "wmm2025"`: the error of that model as one draw a run of total field and dip.
/// `scale` multiplies every size, so that a sweep over it tells first-order from higher-order effects.
sensor::NoiseModel read_noise(config::ConfigReader& config);

/// `[sensor.spread] gain (0), bias_nT (0), axial_bias_nT (0)`: true errors drawn for every run about the nominal ones;
/// axial_bias_nT adds to the bias of z only.
sensor::ToolSpread read_tool_spread(config::ConfigReader& config);

/// `estimator = "msa"` or `[estimator] name, solver, max_iterations, step_tolerance`; `derivative` for estimators that
/// have it. Estimators that weigh also read the sizes that they assume: magnetometer_nT, accelerometer_mps2,
/// `reference = { total_nT, dip_deg }`, `prior = { gain, bias_nT, axial_bias_nT }` (0: no prior), one sd each. Their
/// defaults are the sizes of the simulation (`noise`, and `spread` for the priors). An estimator without a prediction
/// to first order is refused, because every study that reads an estimator compares with its prediction. `names`: those
/// that the study takes.
estimate::EstimatorOptions read_estimator(config::ConfigReader& config, const estimate::InputErrors& truth,
                                          const survey::ReferenceField& field,
                                          const std::vector<std::string>& names = estimate::estimator_names());

/// `estimator.estimated`: which of gain_x to bias_z are unknowns; without it all six.
std::array<bool, 6> read_estimated_parameters(config::ConfigReader& config);

/// `estimator.magnetometer_drawn` ("constant"), for wls only: whether the noise that it assumes of a reading is drawn
/// anew in each run, as "sd" or as "variance".
sensor::AssumedNoise read_assumed_noise(config::ConfigReader& config, const std::string& estimator);

}  // namespace surveymc::scenario
