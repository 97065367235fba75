/// Study: how safely do two wells, or a well and many others, pass each other?
///
///   surveys, slots, error models (config) -> closest points of continuous minimum-curvature paths (proximity)
///   -> relative covariance, by what the wells share -> separation factor and distances in standard deviations
/// With trials, both wells of each pair are drawn, and the relative covariance is held against them.
#include "base/error.h"
#include "clearance/drawn_pairs.h"
#include "clearance/tables.h"
#include "scenario/disturbance.h"
#include "study/experiment.h"

namespace surveymc::studies::clearance {
namespace {

class Clearance final : public study::StudyPoint {
 public:
  /// `drawn`: of the scenario, if it has trials.
  Clearance(std::shared_ptr<const Scenario> scenario, std::unique_ptr<const DrawnPairs> drawn)
      : s_(std::move(scenario)), drawn_(std::move(drawn)) {}

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    return drawn_->run_block(block.first, block.count);
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override {
    const Reference reference = scenario::pair_reference(s_->reference, s_->interpolation);
    Tables tables(*s_);
    // One offset at a time: of each only its rows stay.
    for (const Well& offset : s_->offsets) {
      if (options.stop && *options.stop) throw Interrupted("stopped before all wells were compared");
      tables.add(scenario::well_pair(*s_, reference, offset));
    }
    study::PointResult r;
    r.tables = tables.take(reference);
    if (s_->reference.disturbance)
      r.tables.push_back(scenario::disturbance_table(*s_->reference.disturbance, s_->reference.field, nullptr));
    if (drawn_) r.tables.insert(r.tables.begin(), drawn_->relative_position(tally));
    if (drawn_ && s_->drawing.save_samples > 0) r.samples = {drawn_->realisations(tally)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override { return drawn_ ? drawn_->replay(trial) : ""; }

 private:
  std::shared_ptr<const Scenario> s_;
  std::unique_ptr<const DrawnPairs> drawn_;
};

class ClearancePlan final : public study::PlanOf<Scenario> {
 public:
  using PlanOf::PlanOf;
  std::uint64_t trials() const override { return s_.drawing.trials; }
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions&) const override {
    const auto scenario = std::make_shared<const Scenario>(s_);
    return std::make_unique<Clearance>(scenario, trials() > 0 ? drawn_pairs(*scenario) : nullptr);
  }
};

}  // namespace

study::Experiment experiment() {
  study::Experiment e{
      random::StudyId::clearance, "How safely two wells pass: separation factors from relative covariances",
      "SPE 187073; ISCWSA clearance set and correlation diagnostics", study::plan_of<ClearancePlan, read_scenario>};
  e.approximations = {"zeroed"};
  return e;
}

}  // namespace surveymc::studies::clearance
