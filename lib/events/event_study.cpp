#include "events/event_study.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.h"
#include "compare/table_rows.h"
#include "stats/normal_tail.h"

namespace surveymc::events {
namespace {

constexpr int kSavedNormals = 12;  // the same columns at all points of a sweep

/// An event with its proposal.
struct DrawnEvent {
  TrialEvent of;
  PreparedEvent prepared;
  std::unique_ptr<rare::EventTrials> trials;  ///< null: by subset simulation or as a union

  std::size_t weights() const {
    return rare::kFirstComponent +
           (prepared.of_union ? of.half_spaces.size() : prepared.prepared.proposal.components().size());
  }
  std::uint64_t proposal() const {
    return prepared.of_union ? prepared.of_union->sampler().hash() : prepared.prepared.proposal.hash();
  }
  double beta() const { return prepared.prepared.designs.empty() ? kNaN : prepared.prepared.designs.front().beta; }
};

class EventStudy final : public study::StudyPoint {
 public:
  EventStudy(EventRun run, compare::Annotations annotations, std::vector<DrawnEvent> events, random::Stream stream)
      : run_(std::move(run)), annotations_(std::move(annotations)), events_(std::move(events)), stream_(stream) {}

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally all;
    all.trials = static_cast<std::uint64_t>(block.count);
    for (std::size_t i = 0; i < events_.size(); ++i) {
      const DrawnEvent& e = events_[i];
      if (is_subset()) {
        const stats::Tally t =
            rare::run_subset_replicates(*e.of.state, stream_, block.first, block.count, run_.sampling.subset_samples);
        all.failed += t.failed;
        all.groups.push_back(t.moments);
        all.counts.insert(all.counts.end(), t.counts.begin(), t.counts.end());
        continue;
      }
      const stats::Tally t = e.prepared.of_union ? e.prepared.of_union->run_block(block.first, block.count)
                                                 : weighted_block(e, i, block, all.samples);
      all.weighted.insert(all.weighted.end(), t.weighted.begin(), t.weighted.end());
      all.failed += t.failed;
      for (const std::uint64_t trial : t.failed_trials)
        if (all.failed_trials.size() < stats::Tally::kMaxListed) all.failed_trials.push_back(trial);
    }
    all.proposal = proposal();
    return all;
  }

  std::uint64_t proposal() const override {
    std::uint64_t h = 0;
    for (const DrawnEvent& e : events_) h = h * 0x9e3779b97f4a7c15u + e.proposal();
    return h;
  }

  std::uint64_t trials_needed(const stats::Tally& tally) const override {
    std::uint64_t needed = 0;
    for (std::size_t i = 0; i < events_.size(); ++i)
      needed = std::max(needed,
                        trials_for(estimate(events_[i], part_of(tally, i), {}), tally.trials, run_.plan.relative_ci));
    return needed;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override {
    store::Table probability, sampling, designs;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      const DrawnEvent& e = events_[i];
      const stats::Tally own = part_of(tally, i);
      const EventEstimate found = estimate(e, own, check_of(e, options));
      add(probability, e, probability_table(e, found, own));
      compare::TableRows row("sampling", "how the event was drawn" + compare::at_confidence(run_.verdict.confidence));
      put_sampling(row, e.prepared, found);
      add(sampling, e, row.take());
      compare::TableRows points("design_points",
                                "points of the event nearest to the origin, and what their components hit");
      put_designs(points, e.prepared, own, [](std::size_t) {});
      add(designs, e, points.take());
    }
    study::PointResult r;
    r.tables = {std::move(probability), std::move(sampling), std::move(designs)};
    if (!events_.front().of.normals.empty()) r.tables.push_back(importance_table());
    const bool has_hits = run_.save_samples > 0 && std::any_of(events_.begin(), events_.end(),
                                                               [](const DrawnEvent& e) { return e.trials != nullptr; });
    if (has_hits) r.samples = {hits_table(tally)};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    std::string text = fmt::format("{} {}\n", is_subset() ? "replicate" : "trial", trial);
    for (const DrawnEvent& e : events_) {
      if (events_.size() > 1) text += fmt::format("{}:\n", e.of.name);
      text += replay_of(e, trial);
    }
    return text;
  }

 private:
  bool is_subset() const { return run_.sampling.method == "subset"; }

  stats::Tally weighted_block(const DrawnEvent& e, std::size_t number, montecarlo::TrialBlock block,
                              std::vector<double>& samples) const {
    return e.trials->run_block(
        block.first, block.count, [&](const rare::EventTrial& t, const rare::DrawnTrials& drawn) {
          if (t.trial >= run_.save_samples) return;
          samples.insert(samples.end(), {static_cast<double>(number + 1), static_cast<double>(t.trial), t.weight,
                                         static_cast<double>(t.component), t.g});
          for (int i = 0; i < kSavedNormals; ++i)
            samples.push_back(i < e.of.state->dimension() ? drawn.z.value(t.lane_index, i) : kNaN);
        });
  }

  /// What the tally of all events has of one.
  stats::Tally part_of(const stats::Tally& tally, std::size_t event) const {
    if (is_subset()) return rare::subset_part(tally, event);
    stats::Tally own;
    own.trials = tally.trials;
    std::size_t first = 0;
    for (std::size_t i = 0; i < event; ++i) first += events_[i].weights();
    if (first + events_[event].weights() > tally.weighted.size()) return own;
    const auto begin = tally.weighted.begin() + static_cast<std::ptrdiff_t>(first);
    own.weighted.assign(begin, begin + static_cast<std::ptrdiff_t>(events_[event].weights()));
    own.failed = own.weighted[rare::kLost].count;
    return own;
  }

  EventEstimate estimate(const DrawnEvent& e, const stats::Tally& own, const stats::Tally& check) const {
    return estimate_event(e.prepared, own, check, run_.verdict.confidence, e.of.state->dimension());
  }

  stats::Tally check_of(const DrawnEvent& e, const montecarlo::RunOptions& options) const {
    stats::Tally check;
    for (int r = 0; r < run_.sampling.subset_replicates && !is_subset(); ++r) {
      if (options.stop && *options.stop) throw Interrupted("stopped before the check was done");
      check.merge(rare::run_subset_replicates(*e.of.state, stream_, static_cast<std::uint64_t>(r), 1,
                                              run_.sampling.subset_samples));
    }
    return check;
  }

  static void add(store::Table& all, const DrawnEvent& e, store::Table t) {
    t.columns.insert(t.columns.begin(),
                     {"event", "", "name of the event", std::vector<std::string>(t.rows(), e.of.name)});
    store::append_rows(all, t);
  }

  /// Formulations and predictions that have a row.
  static std::vector<std::pair<std::string, double>> rows_of(const DrawnEvent& e) {
    std::vector<std::pair<std::string, double>> rows;
    for (const auto& p : e.of.predictions)
      if (!std::isnan(p.second)) rows.push_back(p);
    const bool has_form = !std::isnan(e.beta()) && !e.of.is_two_sided;
    if (has_form || rows.empty()) rows.emplace_back("form", has_form ? stats::normal_upper_tail(e.beta()) : kNaN);
    return rows;
  }

  static bool has(const DrawnEvent& e, const std::string& formulation) {
    const auto rows = rows_of(e);
    return std::any_of(rows.begin(), rows.end(), [&](const auto& r) { return r.first == formulation; });
  }

  store::Table probability_table(const DrawnEvent& e, const EventEstimate& found, const stats::Tally& own) const {
    std::vector<compare::ComparisonRow> rows;
    const auto row = [&](const std::string& formulation, double predicted) {
      rows.push_back(compare_probability(formulation, found, predicted, run_.verdict, own.trials));
    };
    for (const auto& [formulation, p] : rows_of(e)) row(formulation, p);
    if (&e == &events_.front())
      for (const std::string& formulation : annotations_.expected_formulations("probability"))
        if (std::none_of(events_.begin(), events_.end(), [&](const DrawnEvent& any) { return has(any, formulation); }))
          row(formulation, kNaN);
    annotations_.apply("probability", rows);
    return compare::comparison_table("probability",
                                     "probability of the event" + compare::at_confidence(run_.verdict.confidence), rows,
                                     own.trials, own.failed, true);
  }

  /// alpha_i^2 of every design point, summed by name; largest first.
  store::Table importance_table() const {
    compare::TableRows t("importance",
                         "squared direction cosines of the design points, by source: which draws make the event");
    const auto put = [&](const std::string& event, std::size_t design, const std::string& code, double factor) {
      t.word("event", "name of the event", event);
      t.count("component", "design point: number of its adapted component in design_points", design);
      t.word("code", "what is drawn", code);
      t.number("factor", "1", "part of beta^2; those of a component add up to 1", factor);
    };
    for (const DrawnEvent& e : events_)
      for (std::size_t k = 0; k < e.prepared.prepared.designs.size(); ++k) {
        const rare::DesignPoint& d = e.prepared.prepared.designs[k];
        std::map<std::string, double> sums;
        for (std::size_t i = 0; i < e.of.normals.size(); ++i) {
          const double alpha = d.z[static_cast<Eigen::Index>(i)] / d.beta;
          if (!e.of.normals[i].empty()) sums[e.of.normals[i]] += alpha * alpha;
        }
        std::vector<std::pair<std::string, double>> sorted(sums.begin(), sums.end());
        std::stable_sort(sorted.begin(), sorted.end(),
                         [](const auto& a, const auto& b) { return a.second > b.second; });
        for (const auto& [code, factor] : sorted) put(e.of.name, k, code, factor);
      }
    return t.take([&] { put({}, 0, {}, 0); });
  }

  store::Table hits_table(const stats::Tally& tally) const {
    store::Table t{"hits", "trials of the events among the first " + std::to_string(run_.save_samples)};
    t.columns = {compare::number_column("event", "1", "number of the event, from 1: the order of the table sampling"),
                 compare::number_column("trial", "1", "number of the trial, from 0"),
                 compare::number_column("weight", "1", "its weight"),
                 compare::number_column("component", "1", "number of the component that drew it, from 0"),
                 compare::number_column("g", "1", "limit state")};
    for (int i = 0; i < kSavedNormals; ++i)
      t.columns.push_back(compare::number_column(fmt::format("z_{}", i + 1), "1", "standard normal"));
    return compare::table_of_numbers(std::move(t), tally.samples);
  }

  std::string replay_of(const DrawnEvent& e, std::uint64_t trial) const {
    if (is_subset()) {
      const rare::SubsetReplicate r =
          rare::subset_simulation(*e.of.state, stream_, trial, run_.sampling.subset_samples);
      return fmt::format("  probability {:.17g}\n  levels {}\n  evaluations {}\n", r.probability, r.levels,
                         r.evaluations);
    }
    if (e.prepared.of_union) {
      const stats::Tally t = e.prepared.of_union->run_block(trial / simd::kGroup * simd::kGroup,
                                                            static_cast<int>(trial % simd::kGroup) + 1);
      return fmt::format("  weight {:.17g} at most\n", t.weighted[rare::kAllHits].largest);
    }
    std::vector<std::string> z;
    const int shown = std::min(kSavedNormals, e.of.state->dimension());
    const rare::EventTrial t = e.trials->replay(trial, [&](const rare::EventTrial& at, const rare::DrawnTrials& drawn) {
      for (int i = 0; i < shown; ++i) z.push_back(fmt::format("{:.17g}", drawn.z.value(at.lane_index, i)));
    });
    const auto& components = e.prepared.prepared.proposal.components();
    return fmt::format("  g {:.17g}{}\n  weight {:.17g}\n  component {}\n  z {}\n", t.g, t.g <= 0 ? ": a hit" : "",
                       t.weight, components.empty() ? "plain" : rare::name_of(components[t.component].kind),
                       fmt::join(z, " "));
  }

  EventRun run_;
  compare::Annotations annotations_;
  std::vector<DrawnEvent> events_;
  random::Stream stream_;
};

/// One evaluation each.
void require_rare(const std::vector<TrialEvent>& events) {
  for (const TrialEvent& e : events) {
    const double g = rare::values_at(*e.state, Eigen::MatrixXd::Zero(e.state->dimension(), 1))[0];
    e.place.require(!(g <= 0), "the event holds where nothing is drawn, and is not rare: must be one that draws cause");
  }
}

struct PlannedEvents {
  compare::TrialPlan trial_plan;
  EventRun run;
  compare::Annotations annotations;
  random::Stream stream;
  std::function<std::vector<TrialEvent>()> events;
  int block_trials;
  double trial_cost;
};

class EventPlan final : public study::PlanOf<PlannedEvents> {
 public:
  using PlanOf::PlanOf;
  int block_trials() const override { return s_.run.block_trials(s_.block_trials); }
  double cost() const override { return s_.trial_cost * PlanOf::cost(); }
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions& options) const override {
    std::vector<TrialEvent> events = s_.events();
    require_rare(events);
    std::vector<DrawnEvent> drawn;
    for (TrialEvent& event : events) {
      if (options.stop && *options.stop) throw Interrupted("stopped before all events were prepared");
      DrawnEvent d{std::move(event), {}, {}};
      const TrialEvent& e = d.of;
      d.prepared = prepare_event(s_.run.sampling, [&] {
        const rare::PreparingOptions& options = s_.run.sampling.preparing;
        return e.has_designs ? rare::prepare_from(*e.state, s_.stream, options, e.starts)
                             : rare::prepare_proposal(*e.state, s_.stream, options, e.starts);
      });
      if (d.prepared.method == "union")
        d.prepared.of_union.emplace(rare::UnionSampler(e.half_spaces), e.half_spaces.size(), s_.stream);
      else if (d.prepared.method != "subset")
        d.trials = std::make_unique<rare::EventTrials>(*e.state, d.prepared.prepared.proposal, e.from, s_.stream);
      drawn.push_back(std::move(d));
    }
    return std::make_unique<EventStudy>(s_.run, s_.annotations, std::move(drawn), s_.stream);
  }
};

}  // namespace

bool has_events(const config::ConfigReader& c) { return c.has("event"); }

std::vector<EventRule> read_events(config::ConfigReader& c, const std::vector<EventQuantity>& quantities) {
  std::vector<std::string> names;
  for (const EventQuantity& q : quantities) names.push_back(q.name);
  std::vector<EventRule> events;
  std::vector<std::string> used;
  for (config::ConfigReader& entry :
       c.tables("event", "events, whose probability is asked for in place of the study's other tables")) {
    EventRule e;
    e.name = entry.text("name", "name of the event, one of its own");
    const std::string quantity = entry.choice("quantity", names, "quantity of a trial that decides");
    e.quantity = static_cast<std::size_t>(std::find(names.begin(), names.end(), quantity) - names.begin());
    e.place = entry.place("quantity");
    const bool has_below = entry.has("below"), has_above = entry.has("above");
    const EventLimits limits = quantities[e.quantity].limits;
    if (limits != EventLimits::none) {
      entry.require(!(has_below && has_above), "above", "not together with below: must be one of the two");
      entry.require(has_below || has_above, "quantity", "without a limit: must have `below` or `above`, a number");
      e.is_above = has_above;
      e.limit =
          entry.number(has_above ? "above" : "below", {},
                       "the event is a quantity on this side of the limit; it must not hold where nothing is drawn");
      const char* key = has_above ? "above" : "below";
      entry.require(has_above || limits != EventLimits::only_above, key,
                    fmt::format("\"{}\" is a size, small where little is drawn, and that is not rare: give `above`, a "
                                "number > 0",
                                quantity));
      entry.require(e.limit > 0 || limits == EventLimits::either, key,
                    fmt::format("\"{}\" is a size, never below 0: must be > 0", quantity));
      e.place = entry.place(key);
    } else {
      entry.require(!has_below && !has_above, has_below ? "below" : "above",
                    fmt::format("\"{}\" happens or not: leave it out", quantity));
    }
    if (!entry.matches_point("at")) continue;
    entry.require(std::find(used.begin(), used.end(), e.name) == used.end(), "name", "two events have it");
    used.push_back(e.name);
    events.push_back(std::move(e));
  }
  c.require(!events.empty(), "event", "none is of this point of the sweep: give one whose `at` has it");
  return events;
}

void refuse_beside_events(const config::ConfigReader& c, const std::vector<std::string>& keys) {
  for (const std::string& key : keys)
    if (c.has(key))
      c.fail(key,
             "is of the study's other tables, of which a run of [[event]] has none: leave one of the two out; "
             "predictions of an event are rows of the table probability");
}

compare::Annotations read_event_annotations(config::ConfigReader& c, const std::vector<std::string>& formulations) {
  std::vector<compare::Row> rows;
  for (const std::string& f : formulations) rows.push_back({"probability", f, "probability"});
  rows.push_back({"probability", "form", "probability"});
  return compare::Annotations::read(c, rows);
}

std::unique_ptr<study::PointPlan> event_plan(EventRun run, compare::Annotations annotations, random::Stream stream,
                                             std::function<std::vector<TrialEvent>()> events, int block_trials,
                                             double trial_cost) {
  require_rare(events());
  const compare::TrialPlan trials = run.plan;
  return std::make_unique<EventPlan>(PlannedEvents{trials, std::move(run), std::move(annotations), stream,
                                                   std::move(events), block_trials, trial_cost});
}

}  // namespace surveymc::events
