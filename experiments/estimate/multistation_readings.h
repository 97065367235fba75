#pragma once
#include <memory>

#include "study/experiment.h"

namespace surveymc::studies::estimate {

/// `estimate` with estimator = "multistation": 6 to 21 errors of both triads (multistation/parameters.h), judged by
/// stations that the fit has not seen. Runs in a hole, and shots of an instrument at unknown attitudes. Throws
/// InputError.
std::unique_ptr<study::PointPlan> multistation_readings_result(config::ConfigReader& config);

}  // namespace surveymc::studies::estimate
