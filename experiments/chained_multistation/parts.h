#pragma once
#include <memory>

#include "study/experiment.h"

namespace surveymc::studies::chained_multistation {

/// One point of `chained_multistation`, by its `study`.
std::unique_ptr<study::PointPlan> performance_plan(config::ConfigReader& config, random::StudySeed seed);
std::unique_ptr<study::PointPlan> unstart_plan(config::ConfigReader& config, random::StudySeed seed);
std::unique_ptr<study::PointPlan> outliers_plan(config::ConfigReader& config, random::StudySeed seed);
std::unique_ptr<study::PointPlan> interference_plan(config::ConfigReader& config, random::StudySeed seed);

}  // namespace surveymc::studies::chained_multistation
