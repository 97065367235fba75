#pragma once
#include <memory>

#include "study/experiment.h"

namespace surveymc::studies::estimate {

/// `estimate` with estimator = "chained": attitudes, drifting offsets and references of all stations of a user's run
/// (estimate/make_model.h). Its noise is in `[model]`, not in `[noise]`. Throws InputError.
std::unique_ptr<study::PointPlan> chained_readings_result(config::ConfigReader& config);

}  // namespace surveymc::studies::estimate
