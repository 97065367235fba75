#pragma once
#include <memory>

#include "study/experiment.h"

namespace surveymc::studies::chained_multistation {

/// One point of `chained_multistation`, by its `study`.
std::unique_ptr<study::PointPlan> performance_plan(config::ConfigReader& config, random::StudySeed seed);
std::unique_ptr<study::PointPlan> unstart_plan(config::ConfigReader& config, random::StudySeed seed);
std::unique_ptr<study::PointPlan> outliers_plan(config::ConfigReader& config, random::StudySeed seed);
std::unique_ptr<study::PointPlan> interference_plan(config::ConfigReader& config, random::StudySeed seed);

/// The plan of a study of a fixed number of trials: a `Point` runs the settings, which have the Scenario `s`.
template <class Point, class Settings, int kBlockRuns>
class FixedPlan final : public study::PlanOf<Settings> {
 public:
  using study::PlanOf<Settings>::PlanOf;
  std::uint64_t trials() const override { return this->s_.s.plan.trials; }
  int block_trials() const override { return kBlockRuns; }
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    return std::make_unique<Point>(this->s_);
  }
};

}  // namespace surveymc::studies::chained_multistation
