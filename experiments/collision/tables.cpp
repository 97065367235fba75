#include "collision/tables.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "base/units.h"
#include "compare/claims.h"
#include "compare/table_rows.h"
#include "proximity/touch_predictions.h"
#include "stats/normal_tail.h"

namespace surveymc::studies::collision {
namespace {

using compare::TableRows;

void put_event(TableRows& t, const PairEvent& e) {
  t.word("offset", "name of the offset well", e.offset());
  t.word("correlation", "what the wells share", e.correlation());
}

store::Table probability_table(const Scenario& s, const std::vector<JudgedEvent>& events) {
  store::Table all;
  for (const JudgedEvent& e : events) {
    const Predictions& p = e.event->predictions();
    std::vector<compare::ComparisonRow> rows;
    for (std::size_t f = 0; f < kFormulations.size(); ++f) {
      compare::ComparisonRow row =
          events::compare_probability(kFormulations[f], e.found, p.probability[f], s.run.verdict, e.tally.trials);
      const std::string own = std::string_view(kFormulations[f]) == "half_space_least_sf"
                                  ? fmt::format("at {:.6g} m of the reference", p.least_sf_pair.reference.md)
                              : p.is_equidistant && std::string_view(kFormulations[f]) != "form"
                                  ? "the wells are equidistant: the closest pair is arbitrary"
                                  : "";
      if (!own.empty()) row.note += (row.note.empty() ? "" : "; ") + own;
      rows.push_back(row);
    }
    s.annotations.apply("probability", rows);
    store::Table t = compare::comparison_table(
        "probability", "probability that the wells touch" + compare::at_confidence(s.run.verdict.confidence), rows,
        e.tally.trials, e.tally.failed, true);
    const std::vector<store::Column> leading{
        {"offset", "", "name of the offset well", std::vector<std::string>(rows.size(), e.event->offset())},
        {"correlation", "", "what the wells share", std::vector<std::string>(rows.size(), e.event->correlation())},
        {"separation_factor", "1", "the least of the pair", std::vector<double>(rows.size(), p.separation_factor)}};
    t.columns.insert(t.columns.begin(), leading.begin(), leading.end());
    store::append_rows(all, t);
  }
  return all;
}

store::Table sampling_table(const Scenario& s, const std::vector<JudgedEvent>& events) {
  TableRows t("sampling", "how the events were drawn" + compare::at_confidence(s.run.verdict.confidence));
  for (const JudgedEvent& e : events) {
    put_event(t, *e.event);
    events::put_sampling(t, e.event->event(), e.found);
    t.estimate("size_slope", "1", "d ln p / d ln of the size of all errors, the slots' left out", e.slope.value,
               {e.slope.lo, e.slope.hi});
    t.number("diluted", "1", "1: larger errors make the probability smaller; 0: not; none: the slope is not known",
             std::isnan(e.slope.hi) ? kNaN
             : e.slope.hi < 0       ? 1
                                    : 0);
  }
  return t.take();
}

store::Table design_table(const std::vector<JudgedEvent>& events) {
  TableRows t("design_points", "the nearest ways to touch, and what their components hit");
  const auto put = [&](const PairEvent& e, std::size_t k, const rare::Component& c, double share) {
    const auto design = static_cast<std::size_t>(std::max(c.design_point, 0));
    const bool has = c.design_point >= 0 && design < e.event().prepared.designs.size();
    const proximity::TouchingPair* at = has && design < e.touching().size() ? &e.touching()[design] : nullptr;
    put_event(t, e);
    t.count("component", "number of the component, from 0", static_cast<std::uint64_t>(k));
    t.word("kind", "adapted, shifted to a design point, or wide", rare::name_of(c.kind));
    t.number("beta", "1", "distance of the design point from the origin",
             has ? e.event().prepared.designs[design].beta : kNaN);
    t.number("share_of_hits", "1", "share of the estimate that this component drew", share);
    t.number("ref_md_m", "m", "where it touches: measured depth of the reference", at ? at->reference.md : kNaN);
    t.number("offset_md_m", "m", "of the offset", at ? at->offset.md : kNaN);
    t.number("distance_m", "m", "distance of the two points as surveyed",
             at ? (at->offset.position - at->reference.position).norm() : kNaN);
  };
  for (const JudgedEvent& e : events) {
    const auto& components = e.event->event().prepared.proposal.components();
    const double all = e.tally.weighted.empty() ? 0 : e.tally.weighted[rare::kAllHits].sum;
    for (std::size_t k = 0; k < components.size(); ++k)
      put(*e.event, k, components[k], all > 0 ? e.tally.weighted[rare::kFirstComponent + k].sum / all : 0);
    if (components.empty() && !e.event->touching().empty()) {  // plain: where they would touch first
      rare::Component c;
      c.design_point = 0;
      put(*e.event, 0, c, kNaN);
    }
  }
  return t.take([&] { put(*events.front().event, 0, {}, 0); });
}

store::Table importance_table(const std::vector<JudgedEvent>& events) {
  TableRows t("importance",
              "squared direction cosines of the design points, by source: which errors make the wells touch");
  const auto put = [&](const PairEvent& e, const PairEvent::Importance& x) {
    put_event(t, e);
    t.count("component", "design point: number of its adapted component in design_points", x.design);
    t.word("code", "code of the error source", x.code);
    t.word("mode", "R, S, W or G", x.mode);
    t.word("well", "whose error, or both: shared", x.well);
    t.number("factor", "1", "part of beta^2; those of a component add up to 1", x.factor);
  };
  for (const JudgedEvent& e : events)
    for (const PairEvent::Importance& x : e.event->importance()) put(*e.event, x);
  return t.take([&] { put(*events.front().event, {}); });
}

store::Table contact_table(const Scenario& s, const std::vector<JudgedEvent>& events) {
  TableRows t("contact",
              "where along both wells the weighted hits touch" + compare::at_confidence(s.run.verdict.confidence));
  for (const JudgedEvent& e : events) {
    if (e.event->event().method == "subset" || e.tally.weighted.empty()) continue;
    const std::size_t first = rare::kFirstComponent + e.event->event().prepared.proposal.components().size();
    const double all = e.tally.weighted[rare::kAllHits].sum;
    for (int well = 0; well < 2; ++well) {
      const auto [lo, hi] = e.event->depths(well);
      double below = 0;
      for (std::size_t b = 0; b < PairEvent::kContactBins; ++b) {
        const stats::WeightedHits& h =
            e.tally.weighted[first + static_cast<std::size_t>(well) * PairEvent::kContactBins + b];
        const double width = (hi - lo) / PairEvent::kContactBins;
        below += h.sum;
        put_event(t, *e.event);
        t.word("well", "reference or offset", well == 0 ? "reference" : "offset");
        t.number("from_md_m", "m", "beginning of the bin", lo + width * static_cast<double>(b));
        t.number("to_md_m", "m", "end of the bin", lo + width * static_cast<double>(b + 1));
        t.count("hits", "trials that touch there", h.count);
        t.number("share", "1", "of the probability", all > 0 ? h.sum / all : kNaN);
        t.number("share_above", "1", "of the probability down to the end of the bin",
                 all > 0 ? std::min(1.0, below / all) : kNaN);
      }
    }
  }
  return t.take([&] {
    put_event(t, *events.front().event);
    t.word("well", "reference or offset", "");
    for (const char* name : {"from_md_m", "to_md_m"}) t.number(name, "m", "", 0);
    t.count("hits", "trials that touch there", 0);
    for (const char* name : {"share", "share_above"}) t.number(name, "1", "", 0);
  });
}

/// Linear within the bins of contact_table().
store::Table contact_quantile_table(const std::vector<JudgedEvent>& events) {
  TableRows t("contact_quantiles",
              "depths above which these shares of the weighted hits touch, from bins of a twentieth");
  const auto put = [&](const PairEvent& e, const std::string& well, double share, double md) {
    put_event(t, e);
    t.word("well", "reference or offset", well);
    t.number("share", "1", "of the probability", share);
    t.number("md_m", "m", "measured depth above which it is", md);
  };
  for (const JudgedEvent& e : events) {
    if (e.event->event().method == "subset" || e.tally.weighted.empty()) continue;
    const std::size_t first = rare::kFirstComponent + e.event->event().prepared.proposal.components().size();
    const double all = e.tally.weighted[rare::kAllHits].sum;
    if (!(all > 0)) continue;
    for (std::size_t well = 0; well < 2; ++well) {
      const auto [lo, hi] = e.event->depths(static_cast<int>(well));
      const double width = (hi - lo) / PairEvent::kContactBins;
      for (const double wanted : {0.05, 0.25, 0.5, 0.75, 0.95}) {
        double above = 0;
        std::size_t b = 0;
        const auto in = [&] { return e.tally.weighted[first + well * PairEvent::kContactBins + b].sum / all; };
        while (b + 1 < PairEvent::kContactBins && above + in() < wanted) above += in(), ++b;
        const double part = in() > 0 ? std::min(1.0, (wanted - above) / in()) : 0;
        put(*e.event, well == 0 ? "reference" : "offset", wanted, lo + width * (static_cast<double>(b) + part));
      }
    }
  }
  return t.take([&] { put(*events.front().event, "", 0, 0); });
}

store::Table closest_table(const std::vector<JudgedEvent>& events) {
  TableRows t("closest_pair",
              "the closest pair of points as surveyed, and the relative covariance there in the plane across "
              "the wells: along the line between them, and across it");
  for (const JudgedEvent& e : events) {
    const proximity::PairPoints& p = e.event->predictions().closest;
    const Eigen::Matrix2d c = e.event->plane_covariance();
    put_event(t, *e.event);
    t.number("ref_md_m", "m", "measured depth of the reference", p.reference.md);
    t.number("offset_md_m", "m", "of the offset", p.offset.md);
    t.number("distance_m", "m", "of the centre lines", p.distance);
    t.number("radii_m", "m", "radii of both holes together", e.event->radii());
    const double cosine = std::abs(p.reference.tangent.dot(p.offset.tangent));
    const double sine = p.reference.tangent.cross(p.offset.tangent).norm();
    t.number("crossing_deg", "deg", "angle at which the wells pass each other, 0 (parallel) to 90",
             std::atan2(sine, cosine) / kDegree);
    t.number("towards_m2", "m2", "variance along the line between the wells", c(0, 0));
    t.number("across_m2", "m2", "variance across it", c(1, 1));
    t.number("cross_m2", "m2", "covariance", c(0, 1));
  }
  return t.take();
}

/// As of clearance, at the closest pair: what the 3-D view draws.
store::Table relative_table(const std::vector<JudgedEvent>& events) {
  TableRows t("relative_covariance",
              "covariance of the relative position at the closest pair, with the places of the slots");
  for (const JudgedEvent& e : events) {
    const proximity::PairPoints& p = e.event->predictions().closest;
    put_event(t, *e.event);
    t.word("where", "closest pair", "closest pair");
    t.number("ref_md_m", "m", "measured depth on the reference", p.reference.md);
    t.number("offset_md_m", "m", "measured depth on the offset", p.offset.md);
    t.word("of", "relative: of the offset from the reference", "relative");
    t.covariance("nev", "covariance, north, east, vertical (down), true north", e.event->predictions().covariance);
  }
  return t.take();
}

constexpr std::size_t kHalfSpace = 0, kHalfSpaceLeastSf = 1, kDisc = 3, kPoint = 4;

/// p-value of two probabilities being the same, against the first being larger; on the logarithm.
double p_of_larger(const events::EventEstimate& a, const events::EventEstimate& b, double confidence) {
  const double quantile = stats::normal_quantile((1 + confidence) / 2);
  const double down = std::log(a.probability / a.interval.lo), up = std::log(b.interval.hi / b.probability);
  const double z = quantile * std::log(a.probability / b.probability) / std::hypot(down, up);
  return std::isfinite(z) ? std::min(1.0, 2 * stats::normal_upper_tail(std::max(z, 0.0))) : kNaN;
}

store::Table claims_table(const Scenario& s, const std::vector<JudgedEvent>& events) {
  const double confidence = s.run.verdict.confidence;
  TableRows t("claims", "statements on the probability that wells touch, held against it");
  const auto put = [&](const std::string& offset, const std::string& correlation, const std::string& claim,
                       const std::string& source, const std::string& what, double value, const std::string& verdict,
                       const compare::Evidence& evidence) {
    t.word("offset", "name of the offset well; all: over all pairs", offset);
    t.word("correlation", "what the wells share", correlation);
    t.word("claim", "the statement", claim);
    t.word("source", "who states it", source);
    t.word("found", "what the number is", what);
    t.number("value", "1", "what was found", value);
    t.word("verdict", "agrees, differs or undecided", verdict);
    t.word("expected", "the verdict this row should have; either: it is a question", "");
    compare::write_evidence(t, evidence, 0);
  };
  // A ratio prediction / probability above (or below) 1, by the whole interval.
  const auto above = [](const JudgedEvent& e, double predicted, bool is_above) -> std::string {
    if (!e.found.trusted || !std::isfinite(predicted)) return "undecided";
    const bool larger = predicted > e.found.interval.hi, smaller = predicted < e.found.interval.lo;
    return larger == smaller ? "undecided" : larger == is_above ? "agrees" : "differs";
  };
  // Of the same claim: that the probability lies below the prediction (or above).
  const auto evidence = [&](const JudgedEvent& e, double predicted, bool is_above) -> compare::Evidence {
    if (!e.found.trusted) return {};
    return compare::claim_evidence(e.found.probability, e.found.interval, predicted, is_above, confidence, true);
  };
  for (const JudgedEvent& e : events) {
    const Predictions& p = e.event->predictions();
    const std::string &offset = e.event->offset(), &correlation = e.event->correlation();
    const double found = e.found.probability;
    const auto add = [&](const std::string& claim, const std::string& source, const std::string& what, double value,
                         double predicted, bool is_above) {
      put(offset, correlation, claim, source, what, value, above(e, predicted, is_above),
          evidence(e, predicted, is_above));
    };
    const std::string loeng = "Loeng 2012, abstract", rule = "SPE 187073: hypothesis test along the closest line";
    add("over whole wells the probability is much larger than at the two closest points", loeng,
        "probability / that of the ball", found / p.probability[kPoint], p.probability[kPoint] * 2, false);
    add("over whole wells the probability is much larger than at the two closest points", loeng,
        "probability / that of the disc", found / p.probability[kDisc], p.probability[kDisc] * 2, false);
    add("the test at the two closest points is on the safe side", rule, "half_space / probability",
        p.probability[kHalfSpace] / found, p.probability[kHalfSpace], true);
    add("the test at the least separation factor is on the safe side", rule, "half_space_least_sf / probability",
        p.probability[kHalfSpaceLeastSf] / found, p.probability[kHalfSpaceLeastSf], true);
    const double three = proximity::touch_chi_squared(p.mahalanobis);
    put(offset, correlation, "the test of three dimensions is more conservative than that of one", "Loeng 2012",
        "chi-square / half_space", three / p.probability[kHalfSpace],
        three > p.probability[kHalfSpace] ? "agrees" : "differs", {});  // no trials: no chance
    put(offset, correlation, "larger errors make a collision likelier", "common use",
        "d ln p / d ln of the size of all errors", e.slope.value,
        e.found.trusted && e.slope.lo > 0   ? "agrees"
        : e.found.trusted && e.slope.hi < 0 ? "differs"
                                            : "undecided",
        e.found.trusted ? compare::claim_evidence(e.slope.value, {e.slope.lo, e.slope.hi}, 0, false, confidence, false)
                        : compare::Evidence{});
    add("the test of three dimensions is on the safe side", "Loeng 2012", "chi-square / probability", three / found,
        three, true);
  }
  // Pairs of events whose factors and probabilities stand in opposite orders, beyond their intervals.
  int wrong = 0, compared = 0;
  double most = kNaN, smallest = kNaN;
  for (const JudgedEvent& a : events)
    for (const JudgedEvent& b : events) {
      const double sa = a.event->predictions().separation_factor, sb = b.event->predictions().separation_factor;
      if (&a == &b || !(sa < sb) || !a.found.trusted || !b.found.trusted) continue;
      ++compared;
      smallest = std::fmin(smallest, p_of_larger(b.found, a.found, confidence));  // the claim: a's is the larger
      if (a.found.interval.hi >= b.found.interval.lo) continue;
      ++wrong;
      most = std::fmax(most, b.found.probability / a.found.probability);
    }
  if (compared > 0)
    put("all", "", "separation factors order the risk", "common use",
        fmt::format("{} of {} pairs stand in the opposite order; by so much at most", wrong, compared),
        wrong > 0 ? most : 1, wrong > 0 ? "differs" : "agrees",
        {std::min(1.0, compared * smallest), kNaN});  // Bonferroni
  for (const JudgedEvent& a : events)
    for (const JudgedEvent& b : events)
      if (a.event->offset() == b.event->offset() && a.event->correlation() == "independent" &&
          b.event->correlation() != "independent") {
        const bool lower = b.found.interval.hi<a.found.interval.lo, higher = b.found.interval.lo> a.found.interval.hi;
        put(a.event->offset(), b.event->correlation(), "shared errors change the risk",
            "ISCWSA correlation diagnostics", "probability with shared errors / without",
            b.found.probability / a.found.probability,
            !a.found.trusted || !b.found.trusted ? "undecided"
            : lower || higher                    ? "agrees"
                                                 : "undecided",
            {});  // it is never said to differ
      }
  // Exact discs of two wells whose envelopes of three sd touch; the hole is a third of its envelope. Sd of each: 1.
  const Eigen::Matrix3d both = 2 * Eigen::Matrix3d::Identity();
  const auto touching = [&](double envelope, double hole) {
    return 1 / proximity::touch_disc({2 * envelope, 0, 0}, both, 2 * hole, Eigen::Vector3d::UnitZ());
  };
  constexpr double kSaid = 300'000;
  for (const auto& [reading, odds] : {std::pair("1 / probability; the hole lies in 3 sd", touching(3, 1)),
                                      {"1 / probability; the envelope is 3 sd and the hole", touching(4.5, 1.5)}})
    put("all", "", "wells with touching envelopes of 3 sd collide less than once in 300,000", "ISCWSA eBook 18.5",
        reading, odds, odds > kSaid ? "agrees" : "differs", {});  // exact: no chance
  return t.take();
}

store::Table warnings_of_wells(const Scenario& s) {
  std::vector<compare::Warning> all = scenario::warnings_of(s.reference);
  for (const scenario::SurveyedWell& w : s.offsets)
    for (compare::Warning& warning : scenario::warnings_of(w)) all.push_back(std::move(warning));
  return compare::warnings_table(all);
}

}  // namespace

std::vector<store::Table> tables_of(const Scenario& s, const std::vector<JudgedEvent>& events) {
  return {probability_table(s, events), sampling_table(s, events), design_table(events),
          importance_table(events),     contact_table(s, events),  contact_quantile_table(events),
          claims_table(s, events),      closest_table(events),     relative_table(events),
          scenario::paths_table(s),     warnings_of_wells(s)};
}

store::Table hits_table(const stats::Tally& tally) {
  store::Table t{"hits", "trials in which the wells touch, among the first"};
  t.columns = {
      compare::number_column("event", "1", "number of the event, from 1: the order of the table sampling"),
      compare::number_column("trial", "1", "number of the trial, from 0"),
      compare::number_column("weight", "1", "its weight"),
      compare::number_column("component", "1", "number of the component that drew it, from 0"),
      compare::number_column("ref_md_m", "m", "where they touch: measured depth of the reference"),
      compare::number_column("offset_md_m", "m", "of the offset"),
      compare::number_column("towards_m", "m",
                             "from the reference to the offset at the closest pair, to first order, in the plane "
                             "across the wells: along the line between them"),
      compare::number_column("across_m", "m", "the same across that line")};
  for (int k = 1; k <= PairEvent::kLeading; ++k)
    t.columns.push_back(compare::number_column(
        fmt::format("leading_{}", k), "1",
        fmt::format("how far source {} of the table importance is drawn towards the first design point, in sd", k)));
  return compare::table_of_numbers(std::move(t), tally.samples);
}

}  // namespace surveymc::studies::collision
