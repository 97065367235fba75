#include "events/event_sampling.h"
#include "config/meanings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace surveymc::events {
namespace {

constexpr double kCheckConfidence = 0.99, kCheckBias = 0.15;
constexpr std::uint64_t kTrustedReplicates = 10;

void add_note(std::string& note, const std::string& text) { note += (note.empty() ? "" : "; ") + text; }

}  // namespace

EventSampling read_event_sampling(config::ConfigReader& c, const std::vector<std::string>& methods) {
  EventSampling s;
  std::vector<std::string> all{"auto", "plain", "importance", "subset"};
  all.insert(all.end(), methods.begin(), methods.end());
  s.method = c.choice("sampling.method", all,
                      "how trials are drawn; 'auto': plain trials if the event is nearer than 2 sd, else importance "
                      "sampling; 'union': from the half spaces that an event is made of, one from its tail",
                      s.method);
  s.preparing.pilot = static_cast<int>(
      c.integer("sampling.pilot", 200, 1'000'000, "evaluations of one round of the preparing", s.preparing.pilot));
  const auto share = [&](const char* key, double& x) {
    x = c.number(std::string("sampling.shares.") + key, config::Range::open(0, 1),
                 "share of the draws from proposals of this kind; the three add up to 1", x);
  };
  share("adapted", s.preparing.adapted);
  share("shifted", s.preparing.shifted);
  share("wide", s.preparing.wide);
  const double sum = s.preparing.adapted + s.preparing.shifted + s.preparing.wide;
  c.require(std::abs(sum - 1) < 1e-9, "sampling.shares", fmt::format("must add up to 1, not to {:.10g}", sum));
  s.subset_samples = static_cast<int>(c.integer("sampling.subset.samples", 100, 1'000'000,
                                                "samples a level of subset simulation, the check", s.subset_samples));
  c.require(s.subset_samples % 10 == 0, "sampling.subset.samples", "must be a multiple of 10");
  s.subset_replicates = static_cast<int>(c.integer(
      "sampling.subset.replicates", 0, 100'000, "replicates of subset simulation; 0: no check", s.subset_replicates));
  c.require(s.subset_replicates != 1, "sampling.subset.replicates",
            "must be 0 (no check) or at least 2: one replicate has no honest interval");
  s.preparing.max_components = static_cast<int>(
      c.integer("sampling.max_components", 1, 64, "most design points that are kept", s.preparing.max_components));
  for (const char* key : {"antithetic", "control_variate"})
    if (c.has(key)) c.fail(key, "not with a proposal: weighted trials have neither; leave it out");
  return s;
}

EventRun read_event_run(config::ConfigReader& c, const std::vector<std::string>& methods) {
  const compare::VerdictRule usual;
  EventRun run;
  run.sampling = read_event_sampling(c, methods);
  run.verdict = {
      c.number("verdict.margin", config::Range::open(0, 1), "margin of the ratio of prediction to Monte Carlo", 0.1),
      c.number("verdict.confidence", compare::kConfidences, config::meaning::kConfidence, usual.confidence),
      usual.nees_margin};
  const compare::Row probability{
      .table = "probability", .quantity = "probability", .predicted = false, .controlled = true};
  run.plan = compare::read_trial_plan(c, {probability}, run.verdict);
  const bool is_subset = run.sampling.method == "subset";
  c.require(!is_subset || run.plan.looks.empty(), "stop",
            "not with sampling.method = \"subset\": give `trials`, the number of replicates");
  if (!is_subset)
    run.save_samples =
        static_cast<std::uint64_t>(c.integer("save_samples", 0, 1'000'000, "trials whose hits are kept", 0));
  return run;
}

PreparedEvent prepare_event(const EventSampling& sampling, const std::function<rare::Prepared()>& prepare) {
  PreparedEvent e;
  e.method = sampling.method;
  if (e.method != "auto" && e.method != "importance") return e;
  e.prepared = prepare();
  if (e.method == "auto") {
    const bool is_near = !e.prepared.designs.empty() && e.prepared.designs.front().beta < kPlainBeta;
    e.method = e.prepared.designs.empty() || is_near ? "plain" : "importance";
  }
  if (e.method == "plain") e.prepared.proposal = {};
  return e;
}

EventEstimate estimate_event(const PreparedEvent& event, const stats::Tally& tally, const stats::Tally& check,
                             double confidence, int dimension) {
  constexpr int kManyDimensions = 10;
  EventEstimate e;
  if (event.method == "subset") {
    const rare::SubsetEstimate s = rare::subset_estimate(tally.moments, confidence);
    e.probability = s.probability;
    e.interval = {s.lo, s.hi};
    e.evaluations = tally.counts.empty() ? 0 : tally.counts[rare::kEvaluations];
    e.relative_half_width = s.probability > 0 ? (s.hi - s.lo) / 2 / s.probability : kNaN;
    const double variance = tally.trials > 1 ? tally.moments.variance(0) / static_cast<double>(tally.trials) : kNaN;
    e.relative_efficiency = s.probability * (1 - s.probability) / (static_cast<double>(e.evaluations) * variance);
    // An interval that reaches 0 says that a few replicates make up the mean, and not how large it may be.
    if (tally.trials < kTrustedReplicates || !(s.lo > 0))
      e.note = !(s.probability > 0) ? "never hit"
               : tally.trials < kTrustedReplicates
                   ? "fewer than 10 replicates"
                   : "the interval of the replicates reaches 0: more of them, or more samples";
    const double lost = tally.moments.count > 0 ? tally.moments.mean[1] : 0;
    if (lost > stats::kMostLost * s.probability)
      add_note(e.note,
               fmt::format("{} evaluations without a result weigh {:.2g} of the hits",
                           tally.counts[rare::kLostEvaluations], s.probability > 0 ? lost / s.probability : kInfinity));
    e.trusted = e.note.empty();
    return e;
  }
  const bool is_plain = event.method == "plain";
  if (!tally.weighted.empty()) {
    e.hits = tally.weighted[rare::kAllHits];
    const stats::WeightedProbability p =
        stats::weighted_probability(e.hits, tally.weighted[rare::kLost], tally.trials, confidence, is_plain);
    e.probability = p.value;
    e.interval = p.interval;
    e.relative_half_width = p.relative_half_width;
    e.relative_efficiency = p.relative_efficiency;
    e.trusted = p.trusted;
    e.note = p.note;
  }
  e.evaluations = tally.trials;
  if (check.trials > 1) {
    e.check = rare::subset_estimate(check.moments, confidence);
    e.check_evaluations = check.counts[rare::kEvaluations];
    const rare::SubsetEstimate wide = rare::subset_estimate(check.moments, kCheckConfidence);
    const stats::WeightedProbability own =
        stats::weighted_probability(e.hits, {}, tally.trials, kCheckConfidence, is_plain);
    if (own.interval.hi < (1 - kCheckBias) * wide.lo) {
      e.trusted = false;
      add_note(e.note, "subset simulation finds more: a mode may be missing");
    } else if (own.interval.lo > (1 + kCheckBias) * wide.hi) {
      // A few replicates are skewed: most lie below their mean. That less is found says nothing against the estimate.
      add_note(e.note, "subset simulation finds less");
    }
  }
  if (event.method == "importance" && dimension > kManyDimensions)
    add_note(e.note, fmt::format("{} normals: a mode of a few per cent could be missed; design_points lists those that "
                                 "are covered",
                                 dimension));
  return e;
}

std::uint64_t trials_for(const EventEstimate& e, std::uint64_t trials, double relative_ci) {
  const double width = e.relative_half_width / relative_ci;
  if (!std::isfinite(width)) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(std::min(1e18, std::ceil(static_cast<double>(trials) * width * width)));
}

compare::ComparisonRow compare_probability(const std::string& formulation, const EventEstimate& found, double predicted,
                                           const compare::VerdictRule& rule, std::uint64_t trials) {
  compare::ComparisonRow row =
      compare::compare_value("probability", "1", {found.probability, found.interval}, predicted, rule, trials);
  row.formulation = formulation;
  if (!found.note.empty()) row.note = row.note.empty() ? found.note : found.note + "; " + row.note;
  if (found.trusted || !std::isfinite(predicted)) return row;
  row.verdict = "undecided";
  row.margin = rule.margin;
  row.evidence = {};
  row.trials_to_decide = 0;
  return row;
}

void put_sampling(compare::TableRows& t, const PreparedEvent& event, const EventEstimate& e) {
  const auto components = event.prepared.proposal.components().size();
  const bool has_hits = event.method != "subset";  // whose samples of the event depend on each other
  t.word("method", "how trials are drawn", event.method);
  t.count("evaluations_preparing", "evaluations before the main run", event.prepared.evaluations);
  t.count("evaluations", "evaluations of the main run", e.evaluations);
  t.number("hits", "1", "trials of the event", has_hits ? static_cast<double>(e.hits.count) : kNaN);
  t.number("effective_hits", "1", "S1^2 / S2: so many hits of equal weight tell as much",
           has_hits ? e.hits.effective_hits() : kNaN);
  t.number("largest_share", "1", "share of the largest weight in the sum", has_hits ? e.hits.largest_share() : kNaN);
  t.number("relative_half_width", "1", "half width of the interval, of the probability", e.relative_half_width);
  t.number("relative_efficiency", "1", "how many plain trials an evaluation is worth", e.relative_efficiency);
  t.count("components", "components of the mixture; 0: none", static_cast<std::uint64_t>(components));
  t.number("subset_probability", "1", "the same by replicates of subset simulation", e.check.probability,
           "subset_ci_low subset_ci_high");
  t.number("subset_ci_low", "1", "lower bound of its interval", e.check.lo);
  t.number("subset_ci_high", "1", "upper bound of its interval", e.check.hi);
  t.count("evaluations_check", "evaluations of these replicates", e.check_evaluations);
  t.count("trusted", "1: the interval may be relied on", e.trusted ? 1 : 0);
  t.word("note", "why not, and what else there is to say", e.note);
}

void put_designs(compare::TableRows& t, const PreparedEvent& event, const stats::Tally& tally,
                 const std::function<void(std::size_t)>& more) {
  const auto& components = event.prepared.proposal.components();
  const auto put = [&](std::size_t k, const rare::Component& c) {
    const bool has_design = c.design_point >= 0;
    t.count("component", "number of the component, from 0", static_cast<std::uint64_t>(k));
    t.word("kind", "adapted, shifted to a design point, or wide", rare::name_of(c.kind));
    t.number("share", "1", "share of the draws", c.share);
    t.number("beta", "1", "distance of the design point from the origin",
             has_design ? event.prepared.designs[static_cast<std::size_t>(c.design_point)].beta : kNaN);
    const double all = tally.weighted.empty() ? 0 : tally.weighted[rare::kAllHits].sum;
    const bool has_hits = all > 0 && tally.weighted.size() > rare::kFirstComponent + k;
    t.number("share_of_hits", "1", "share of the estimate that this component drew",
             has_hits ? tally.weighted[rare::kFirstComponent + k].sum / all : 0);
    more(has_design ? static_cast<std::size_t>(c.design_point) : event.prepared.designs.size());
  };
  if (components.empty()) {  // the columns alone
    put(0, {});
    t.drop_rows();
  }
  for (std::size_t k = 0; k < components.size(); ++k) put(k, components[k]);
}

}  // namespace surveymc::events
