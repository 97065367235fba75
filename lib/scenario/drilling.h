#pragma once
/// Reads from a config how the tool was turned, and the sizes of its constant sensor errors.
#include "config/config.h"
#include "random/stream.h"
#include "random/study_stream.h"
#include "survey/reference_field.h"
#include "survey/sensor_terms.h"
#include "survey/survey.h"
#include "survey/toolface_plan.h"

namespace surveymc::scenario {

/// The modes of `drilling.mode` that need nothing but depths.
inline const std::vector<std::string> kDrillingModes{"sliding", "rotating", "fixed_sequence", "random", "mixed"};

/// `[drilling] mode` (one of kDrillingModes) and
///   toolface_deg               sliding: the toolface; drawn once a run if absent
///   sequence (0)               fixed_sequence, and random, which is another word for it: toolfaces of the run of this
///                              number of the rotated well of the same seed
///   slide_from_m, slide_to_m   mixed: slid between these measured depths, rotated elsewhere
/// Values that the mode does not use may stand there, so that `mode` can be swept. `toolface_zero` (rad) is added to
/// toolface_deg. Throws InputError.
survey::ToolfacePlan read_drilling(config::ConfigReader& config, const std::vector<double>& md, double toolface_zero,
                                   const random::Stream& stream,
                                   const std::vector<std::string>& modes = kDrillingModes);

/// The survey of a study that computes with one toolface a station, the same in every run. Without `[drilling]`, or
/// with its mode "survey", toolfaces are those of the file. Else the file needs none:
///   mode = "rotating"  turned by the golden angle, 137.5 deg, from station to station: evenly round the tool
///   mode = "sliding"   all of them drilling.toolface_deg (0), from the axis that survey.toolface_zero ("y") names
///   mode = "random"    uniform, independent: those of the run of number drilling.sequence (0) of a rotated well
/// Throws InputError, also where toolfaces are drawn and the config has no seed.
survey::Survey read_drilled_survey(config::ConfigReader& config, const survey::ReferenceField& field,
                                   random::StudySeed seed);

/// `[sensor_errors] accelerometer_bias_mps2 (0), accelerometer_scale (0), magnetometer_bias_nT (0), magnetometer_scale
/// (0)`: one standard deviation each, the same for x, y, z; `multiplier (1)` of them all.
survey::SensorTermArray read_sensor_errors(config::ConfigReader& config);

}  // namespace surveymc::scenario
