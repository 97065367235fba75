#pragma once
#include <memory>

#include "study/experiment.h"

namespace surveymc {

/// `estimate` with estimator = "chained": attitudes, drifting offsets and references of all stations of a user's run
/// (estimate/chained_model.h). Its noise is in `[model]`, not in `[noise]`. Throws InputError.
std::unique_ptr<PointPlan> estimate_chained(ConfigReader& config);

}  // namespace surveymc
