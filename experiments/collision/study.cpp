/// Study: how likely do two wells touch, anywhere along their paths?
///
///   surveys, slots, error models (config) -> nearest way to touch over all pairs of points
///   (proximity/contact_design.h)
///   -> mixture adapted to it (rare/preparing.h) -> both wells drawn, least distance of both paths, weights
/// held against the predictions of one pair of points.
#include <fmt/format.h>

#include "base/error.h"
#include "collision/tables.h"
#include "random/study_stream.h"
#include "scenario/disturbance.h"
#include "study/experiment.h"

namespace surveymc::studies::collision {
namespace {

class Collision final : public study::StudyPoint {
 public:
  Collision(std::shared_ptr<const Scenario> scenario, std::vector<std::unique_ptr<const PairEvent>> events)
      : s_(std::move(scenario)), events_(std::move(events)) {}

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally all;
    all.trials = static_cast<std::uint64_t>(block.count);
    if (is_subset()) {
      for (const auto& e : events_) {
        const stats::Tally t = e->subset_replicates(block.first, block.count);
        all.failed += t.failed;
        all.groups.push_back(t.moments);
        all.counts.insert(all.counts.end(), t.counts.begin(), t.counts.end());
      }
      return all;
    }
    for (std::size_t i = 0; i < events_.size(); ++i) {
      stats::Tally t = events_[i]->run_block(block.first, block.count, i);
      all.weighted.insert(all.weighted.end(), t.weighted.begin(), t.weighted.end());
      all.samples.insert(all.samples.end(), t.samples.begin(), t.samples.end());
      all.failed += t.failed;
      all.groups.push_back(std::move(t.moments));
    }
    all.proposal = proposal();
    return all;
  }

  std::uint64_t proposal() const override {
    std::uint64_t h = 0;
    for (const auto& e : events_) h = h * 0x9e3779b97f4a7c15u + e->event().prepared.proposal.hash();
    return h;
  }

  std::uint64_t trials_needed(const stats::Tally& tally) const override {
    std::uint64_t needed = 0;
    for (const JudgedEvent& e : judged(tally, {}))
      needed = std::max(needed, events::trials_for(e.found, tally.trials, s_->run.plan.relative_ci));
    return needed;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override {
    std::vector<stats::Tally> checks(events_.size());
    if (!is_subset())
      for (std::size_t i = 0; i < events_.size(); ++i)
        for (int r = 0; r < s_->run.sampling.subset_replicates && !events_[i]->touching().empty(); ++r) {
          if (options.stop && *options.stop) throw Interrupted("stopped before the check was done");
          checks[i].merge(events_[i]->subset_replicates(static_cast<std::uint64_t>(r), 1));
        }
    study::PointResult r;
    r.tables = tables_of(*s_, judged(tally, checks));
    if (s_->reference.disturbance)
      r.tables.push_back(scenario::disturbance_table(*s_->reference.disturbance, s_->reference.field, nullptr));
    if (s_->run.save_samples > 0) r.samples = {hits_table(tally)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    std::string text = fmt::format("trial {}\n", trial);
    for (const auto& e : events_) text += e->replay(trial);
    return text;
  }

 private:
  bool is_subset() const { return s_->run.sampling.method == "subset"; }

  std::vector<JudgedEvent> judged(const stats::Tally& tally, const std::vector<stats::Tally>& checks) const {
    std::vector<JudgedEvent> out;
    std::size_t first = 0;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      const PairEvent& e = *events_[i];
      JudgedEvent j{&e, {}, {}};
      j.tally.trials = tally.trials;
      if (is_subset()) {
        j.tally = rare::subset_part(tally, i);
      } else if (first + e.weights() <= tally.weighted.size()) {
        const auto begin = tally.weighted.begin() + static_cast<std::ptrdiff_t>(first);
        j.tally.weighted.assign(begin, begin + static_cast<std::ptrdiff_t>(e.weights()));
        j.tally.failed = j.tally.weighted[rare::kLost].count;
        if (i < tally.groups.size()) j.slope = e.size_slope(tally.groups[i], s_->run.verdict.confidence);
        first += e.weights();
      }
      j.found = events::estimate_event(e.event(), j.tally, checks.empty() ? stats::Tally{} : checks[i],
                                       s_->run.verdict.confidence, 0);
      if (e.touching().empty()) {
        j.found.probability = 0;
        j.found.interval = {0, 0};
        j.found.note = "impossible, p = 0: no source moves the wells to each other";
      }
      out.push_back(std::move(j));
    }
    return out;
  }

  std::shared_ptr<const Scenario> s_;
  std::vector<std::unique_ptr<const PairEvent>> events_;
};

std::vector<std::unique_ptr<const PairEvent>> events_of(const Scenario& s, const montecarlo::RunOptions& options) {
  const scenario::PairReference reference = scenario::pair_reference(s.reference, s.interpolation);
  const propagate::WellErrors drawn = scenario::drawn_errors(s.reference, s.reference.tools, s.vertical);
  const random::Stream stream = random::stream_of(s.seed);
  std::vector<std::unique_ptr<const PairEvent>> events;
  for (std::size_t o = 0; o < s.offsets.size(); ++o)
    for (const scenario::PairFormulation& f : s.formulations) {
      if (!f.is_for(s.offsets[o])) continue;
      if (options.stop && *options.stop) throw Interrupted("stopped before all pairs were prepared");
      events.push_back(pair_event(s, reference, drawn, o, f, stream));
    }
  return events;
}

class CollisionPlan final : public study::PlanOf<Scenario> {
 public:
  using PlanOf::PlanOf;
  std::uint64_t trials() const override { return s_.run.plan.trials; }
  std::vector<std::uint64_t> looks() const override { return s_.run.plan.looks; }
  int block_trials() const override { return s_.run.block_trials(); }
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions& options) const override {
    const auto scenario = std::make_shared<const Scenario>(s_);
    return std::make_unique<Collision>(scenario, events_of(*scenario, options));
  }
};

}  // namespace

study::Experiment experiment() {
  study::Experiment e{random::StudyId::collision, "How likely two wells touch: importance sampling of whole wells",
                      "Loeng 2012; SPE 187073; ISCWSA clearance set and correlation diagnostics",
                      study::plan_of<CollisionPlan, read_scenario>};
  e.approximations = {"half_space", "half_space_least_sf", "slab", "disc", "point", "form"};
  return e;
}

}  // namespace surveymc::studies::collision
