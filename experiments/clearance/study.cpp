/// Study: how safely do two wells, or a well and many others, pass each other?
///
///   surveys, slots, error models (config) -> closest points of continuous minimum-curvature paths (clearance)
///   -> relative covariance, by what the wells share -> separation factor and distances in standard deviations
#include "base/error.h"
#include "clearance/tables.h"
#include "study/experiment.h"

namespace surveymc::studies::clearance {
namespace {

class Clearance final : public study::StudyPoint {
 public:
  explicit Clearance(std::shared_ptr<const Scenario> scenario) : s_(std::move(scenario)) {}

  study::PointResult report(const stats::Tally&, const montecarlo::RunOptions& options) const override {
    const Reference reference(s_->reference, s_->interpolation);
    Tables tables(*s_);
    // One offset at a time: of each only its rows stay.
    for (const Well& offset : s_->offsets) {
      if (options.stop && *options.stop) throw Interrupted("stopped before all wells were compared");
      tables.add(Pair(*s_, reference, offset));
    }
    return {tables.take(reference), {}, {}};
  }

 private:
  std::shared_ptr<const Scenario> s_;
};

class ClearancePlan final : public study::PointPlan {
 public:
  explicit ClearancePlan(Scenario scenario) : s_(std::make_shared<const Scenario>(std::move(scenario))) {}
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    return std::make_unique<Clearance>(s_);
  }

 private:
  std::shared_ptr<const Scenario> s_;
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::clearance, "How safely two wells pass: separation factors from relative covariances",
          "SPE 187073; ISCWSA clearance set and correlation diagnostics",
          [](config::ConfigReader& config, random::StudySeed) -> std::unique_ptr<study::PointPlan> {
            return std::make_unique<ClearancePlan>(read_scenario(config));
          }};
}

}  // namespace surveymc::studies::clearance
