#pragma once
#include <memory>

#include "study/experiment.h"

namespace surveymc {

/// One point of `chained_multistation`, by its `study`.
std::unique_ptr<PointPlan> chained_performance(ConfigReader& config, StudySeed seed);
std::unique_ptr<PointPlan> chained_unstart(ConfigReader& config, StudySeed seed);
std::unique_ptr<PointPlan> chained_outliers(ConfigReader& config, StudySeed seed);
std::unique_ptr<PointPlan> chained_interference(ConfigReader& config, StudySeed seed);

}  // namespace surveymc
