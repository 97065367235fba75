/// Study: limit states with known probabilities, to try the methods for rare events on.
///
///   problem (config) -> preparing (rare/preparing.h) -> weighted trials -> probability with its interval,
///   held against the exact value and against FORM, and beside replicates of subset simulation
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "base/units.h"
#include "random/rare_channels.h"
#include "random/study_stream.h"
#include "rare/test_functions.h"
#include "stats/normal_tail.h"
#include "study/annotations.h"
#include "study/event_sampling.h"
#include "study/experiment.h"
#include "study/scenario.h"
#include "study/table_rows.h"

namespace surveymc::studies::rare_event {
namespace {

struct Scenario {
  random::StudySeed seed;
  study::TrialPlan plan;
  std::uint64_t save_samples = 0;
  rare::TestProblem problem;
  study::EventSampling sampling;
  study::VerdictRule verdict;
  study::Annotations annotations;
};

constexpr int kMostNormals = 10'000;

rare::TestProblem read_problem(config::ConfigReader& c) {
  rare::TestProblem p;
  const std::vector<std::string>& names = rare::test_problem_names();
  p.name = c.choice("problem.name", names);
  const auto size = [&](int usual) {
    p.dimension = static_cast<int>(c.integer("problem.dimension", 1, kMostNormals, usual));
  };
  constexpr double kMostBeta = 35;  // its probability is 1e-268
  const config::Range distance = config::Range{0, kMostBeta, true, false};
  if (p.name == "linear") {
    size(2);
    p.beta = {c.number("problem.beta", distance)};
  } else if (p.name == "union") {
    p.beta = c.numbers("problem.beta", distance);
    size(static_cast<int>(p.beta.size()));
    c.require(p.beta.size() <= static_cast<std::size_t>(p.dimension), "problem.beta",
              fmt::format("has {} values: must have at most problem.dimension = {}", p.beta.size(), p.dimension));
  } else if (p.name == "product") {
    p.level = c.number("problem.level", config::Range{0, 600, true, false});
  } else if (p.name == "sphere") {
    size(2);
    p.radius = c.number("problem.radius", distance);
  } else if (p.name == "disc") {
    p.mean = c.numbers("problem.mean", {}, 2);
    p.sd = c.numbers("problem.sd", config::Range::positive(), 2);
    p.radius = c.number("problem.radius", config::Range::positive());
    c.require(std::hypot(p.mean[0], p.mean[1]) > p.radius, "problem.mean",
              "lies on the disc: the event holds at z = 0, and is not rare");
  }
  return rare::with_dimension(p);
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.problem = read_problem(c);
  const bool is_union = !rare::half_spaces_of(s.problem).empty();
  s.sampling = study::read_event_sampling(c, {"union"});
  c.require(s.sampling.method != "union" || is_union, "sampling.method",
            "the event is no union of half spaces: must be of another method, or the problem \"linear\" or \"union\"");
  s.verdict = study::read_event_verdict(c);
  s.plan = study::read_trial_plan(c, {"probability"}, {}, s.verdict);
  c.require(s.sampling.method != "subset" || s.plan.looks.empty(), "stop",
            "not with sampling.method = \"subset\": give `trials`, the number of replicates");
  if (s.sampling.method != "subset")
    s.save_samples = static_cast<std::uint64_t>(c.integer("save_samples", 0, 1'000'000, 0));
  s.annotations =
      study::Annotations::read(c, {{"probability", "exact", "probability"}, {"probability", "form", "probability"}});
  c.finish();
  return s;
}

class RareEvent final : public study::StudyPoint {
 public:
  RareEvent(const Scenario& scenario, const montecarlo::RunOptions& options)
      : s_(scenario), stream_(random::stream_of(scenario.seed)), state_(rare::test_limit_state(scenario.problem)) {
    event_ = study::prepare_event(s_.sampling, [&] {
      if (options.stop && *options.stop) throw Interrupted("stopped before the proposal was prepared");
      return rare::prepare_proposal(*state_, stream_, s_.sampling.preparing);
    });
    if (event_.method == "union") {
      const std::vector<rare::HalfSpace> half_spaces = rare::half_spaces_of(s_.problem);
      event_.of_union.emplace(rare::UnionSampler(half_spaces), half_spaces.size(), stream_);
    }
    trials_ = std::make_unique<rare::EventTrials>(
        *state_, event_.prepared.proposal,
        rare::addresses_in(random::kRareNormal, random::kRareChoice, s_.problem.dimension), stream_);
  }

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    if (event_.method == "subset")
      return rare::run_subset_replicates(*state_, stream_, block.first, block.count, s_.sampling.subset_samples);
    if (event_.of_union) return event_.of_union->run_block(block.first, block.count);
    std::vector<double> samples;
    stats::Tally tally =
        trials_->run_block(block.first, block.count, [&](const rare::EventTrial& t, const rare::DrawnTrials& drawn) {
          if (t.trial >= s_.save_samples) return;
          samples.insert(samples.end(),
                         {static_cast<double>(t.trial), t.weight, static_cast<double>(t.component), t.g});
          for (int i = 0; i < kSavedNormals; ++i)
            samples.push_back(i < s_.problem.dimension ? drawn.z.value(t.lane_index, i) : kNaN);
        });
    tally.samples = std::move(samples);
    return tally;
  }

  std::uint64_t proposal() const override {
    return event_.of_union ? event_.of_union->sampler().hash() : event_.prepared.proposal.hash();
  }

  std::uint64_t trials_needed(const stats::Tally& tally) const override {
    return study::trials_for(estimate(tally, {}), tally.trials, s_.plan.relative_ci);
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override {
    stats::Tally check;
    if (event_.method != "subset" && s_.sampling.subset_replicates > 0)
      for (int r = 0; r < s_.sampling.subset_replicates; ++r) {
        if (options.stop && *options.stop) throw Interrupted("stopped before the check was done");
        check.merge(rare::run_subset_replicates(*state_, stream_, static_cast<std::uint64_t>(r), 1,
                                                s_.sampling.subset_samples));
      }
    const study::EventEstimate found = estimate(tally, check);
    const double beta = event_.prepared.designs.empty() ? kNaN : event_.prepared.designs.front().beta;
    std::vector<study::ComparisonRow> rows{
        study::compare_probability("exact", found, rare::exact_probability(s_.problem), s_.verdict, tally.trials),
        study::compare_probability("form", found, stats::normal_upper_tail(beta), s_.verdict, tally.trials)};
    if (std::isnan(beta)) rows.pop_back();
    s_.annotations.apply("probability", rows);
    store::Table probability =
        study::comparison_table("probability", "probability of the event" + study::at_confidence(s_.verdict.confidence),
                                rows, tally.trials, tally.failed, true);
    const auto add_event = [&](store::Table& t) {
      t.columns.insert(t.columns.begin(),
                       {"event", "", "name of the problem", std::vector<std::string>(t.rows(), s_.problem.name)});
    };
    add_event(probability);
    study::TableRows sampling("sampling", "how the event was drawn" + study::at_confidence(s_.verdict.confidence));
    study::put_sampling(sampling, event_, found);
    store::Table sampled = sampling.take();
    add_event(sampled);
    study::PointResult r;
    r.tables = {std::move(probability), std::move(sampled), designs(tally)};
    add_event(r.tables.back());
    if (s_.save_samples > 0 && !event_.of_union) r.samples = {hits_table(tally)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    if (event_.method == "subset") {
      const rare::SubsetReplicate r = rare::subset_simulation(*state_, stream_, trial, s_.sampling.subset_samples);
      return fmt::format("replicate {}\n  probability {:.17g}\n  levels {}\n  evaluations {}\n", trial, r.probability,
                         r.levels, r.evaluations);
    }
    if (event_.of_union) {
      const stats::Tally t =
          event_.of_union->run_block(trial / simd::kGroup * simd::kGroup, static_cast<int>(trial % simd::kGroup) + 1);
      return fmt::format("trial {}\n  weight {:.17g} at most\n", trial, t.weighted[rare::kAllHits].largest);
    }
    std::vector<std::string> z;
    const rare::EventTrial t = trials_->replay(trial, [&](const rare::EventTrial& at, const rare::DrawnTrials& drawn) {
      for (int i = 0; i < s_.problem.dimension; ++i)
        z.push_back(fmt::format("{:.17g}", drawn.z.value(at.lane_index, i)));
    });
    return fmt::format("trial {}\n  g {:.17g}{}\n  weight {:.17g}\n  component {}\n  z {}\n", trial, t.g,
                       t.g <= 0 ? ": a hit" : "", t.weight, component_name(t.component), fmt::join(z, " "));
  }

 private:
  static constexpr int kSavedNormals = 12;  // the same columns at all points of a sweep

  study::EventEstimate estimate(const stats::Tally& tally, const stats::Tally& check) const {
    return study::estimate_event(event_, tally, check, s_.verdict.confidence, s_.problem.dimension);
  }

  std::string component_name(std::size_t k) const {
    const auto& all = event_.prepared.proposal.components();
    return k < all.size() ? rare::name_of(all[k].kind) : "plain";
  }

  store::Table designs(const stats::Tally& tally) const {
    study::TableRows t("design_points", "points of the event nearest to the origin, and what their components hit");
    study::put_designs(t, event_, tally, [](std::size_t) {});
    return t.take();
  }

  store::Table hits_table(const stats::Tally& tally) const {
    store::Table t{"hits", "trials of the event among the first " + std::to_string(s_.save_samples)};
    t.columns = {study::number_column("trial", "1", "number of the trial, from 0"),
                 study::number_column("weight", "1", "its weight"),
                 study::number_column("component", "1", "number of the component that drew it, from 0"),
                 study::number_column("g", "1", "limit state")};
    for (int i = 0; i < kSavedNormals; ++i)
      t.columns.push_back(study::number_column(fmt::format("z_{}", i + 1), "1", "standard normal"));
    return study::table_of_numbers(std::move(t), tally.samples);
  }

  Scenario s_;
  random::Stream stream_;
  std::unique_ptr<rare::LimitState> state_;
  study::PreparedEvent event_;
  std::unique_ptr<rare::EventTrials> trials_;
};

class RareEventPlan final : public study::PointPlan {
 public:
  explicit RareEventPlan(Scenario scenario) : s_(std::move(scenario)) {}
  std::uint64_t trials() const override { return s_.plan.trials; }
  std::vector<std::uint64_t> looks() const override { return s_.plan.looks; }
  int block_trials() const override { return s_.sampling.method == "subset" ? 1 : montecarlo::kBlockTrials; }
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions& options) const override {
    return std::make_unique<RareEvent>(s_, options);
  }

 private:
  Scenario s_;
};

}  // namespace

study::Experiment experiment() {
  return {random::StudyId::rare_event, "Test functions of rare events: importance sampling against exact probabilities",
          "black-box reliability challenge 2019; Waarts 2000; Owen, Maximov and Chertkov 2019",
          [](config::ConfigReader& config, random::StudySeed seed) -> std::unique_ptr<study::PointPlan> {
            return std::make_unique<RareEventPlan>(read_scenario(config, seed));
          }};
}

}  // namespace surveymc::studies::rare_event
