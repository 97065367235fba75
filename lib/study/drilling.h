#pragma once
/// From a config to how the tool was turned, and to the sizes of its constant sensor errors.
#include "config/config.h"
#include "random/stream.h"
#include "survey/sensor_terms.h"
#include "survey/toolface_plan.h"

namespace surveymc::study {

/// The modes of `drilling.mode` that need nothing but depths.
inline const std::vector<std::string> kDrillingModes{"sliding", "rotating", "fixed_sequence", "mixed"};

/// `[drilling] mode` (one of kDrillingModes) and
///   toolface_deg               sliding: the toolface; drawn once a run if absent
///   sequence (0)               fixed_sequence: toolfaces of the run of this number of the rotated well of the same
///   seed slide_from_m, slide_to_m   mixed: slid between these measured depths, rotated elsewhere
/// Values that the mode does not use may stand there, so that `mode` can be swept. `toolface_zero` (rad) is added to
/// toolface_deg. Throws InputError.
survey::ToolfacePlan read_drilling(config::ConfigReader& config, const std::vector<double>& md, double toolface_zero,
                                   const random::Stream& stream,
                                   const std::vector<std::string>& modes = kDrillingModes);

/// `[sensor_errors] accelerometer_bias_mps2 (0), accelerometer_scale (0), magnetometer_bias_nT (0), magnetometer_scale
/// (0)`: one standard deviation each, the same for x, y, z; `multiplier (1)` of them all.
survey::SensorTermArray read_sensor_errors(config::ConfigReader& config);

}  // namespace surveymc::study
