#include "clearance/tables.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/ranges.h>

#include "base/units.h"
#include "proximity/heavy_separation.h"
#include "stats/normal_tail.h"
#include "survey/survey.h"

namespace surveymc::studies::clearance {
namespace {

using Eigen::Matrix3d;
using proximity::LeastOf;
using proximity::PairClearance;
using proximity::PairErrors;
using proximity::PairPoints;
using proximity::PathEnd;
using proximity::ScanDirection;

const char* direction_name(ScanDirection d) { return d == ScanDirection::reference ? "reference" : "offset"; }
const char* end_name(PathEnd e) { return e == PathEnd::interior ? "interior" : e == PathEnd::start ? "start" : "end"; }
const char* least_name(LeastOf q) {
  return q == LeastOf::separation_factor ? "separation_factor" : q == LeastOf::distance ? "distance" : "mahalanobis";
}

void write_wells(compare::TableRows& t, const std::string& offset, const std::string& formulation) {
  t.word("offset", "name of the offset well", offset);
  t.word("formulation", "which errors the two wells share", formulation);
}

}  // namespace

double quantity_of(const std::string& name, const PairPoints& p, const PairClearance& c) {
  const std::array<double, 13> values{p.reference.md,       p.offset.md,          p.distance,       p.bearing / kDegree,
                                      p.toolface / kDegree, c.sd_reference,       c.sd_offset,      c.sd_relative,
                                      c.separation_factor,  c.ellipse_separation, c.sigma_distance, c.mahalanobis,
                                      c.ellipsoid_factor};
  const auto& names = published_quantities();
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? kNaN : values[static_cast<std::size_t>(at - names.begin())];
}

Tables::Tables(const Scenario& scenario)
    : s_(scenario),
      clearance_("clearance", "pairs of closest points of two wells, and how far they are apart; sd are one sigma"),
      least_("least",
             fmt::format("the least separation factor, distance and Mahalanobis distance of each pair of wells; "
                         "kept: separation factor at least 1, k = {:g}, S_m = {:g} m, sigma_pa = {:g} m",
                         scenario.rule.scale_factor, scenario.rule.surface_margin, scenario.rule.project_ahead)),
      covariance_("relative_covariance", "covariances at the least separation factor and at the depths of report_md_m"),
      tails_("tails",
             "what the separation rule's k stands for with the laws of the reference, at the least separation factor") {
}

void Tables::add(const Pair& pair) {
  for (const ScanDirection direction : s_.directions) {
    const std::vector<PairPoints> points = proximity::scan(pair.geometry, direction, s_.step, s_.keep);
    // At its kick-off a sidetrack is the reference: a row of the table, but no least separation worth knowing.
    if (s_.with_rows && pair.offset->kickoff)
      add_clearance(pair, direction,
                    {proximity::pair_at(pair.geometry, direction, pair.offset_path->md(*pair.offset->kickoff))});
    if (s_.with_rows) add_clearance(pair, direction, points);
    std::vector<PairPoints> closest;
    for (const PairPoints& p : points)
      if (p.minimum == 1) closest.push_back(p);
    std::vector<PairPoints> samples = proximity::least_samples(pair.geometry, direction);
    if (s_.step > 0) {  // points between stations are samples, too; what is least at stations is of stations alone
      const auto scanned_md = [&](const PairPoints& p) {
        return direction == ScanDirection::reference ? p.reference.md : p.offset.md;
      };
      samples.insert(samples.end(), closest.begin(), closest.end());
      std::stable_sort(samples.begin(), samples.end(),
                       [&](const PairPoints& a, const PairPoints& b) { return scanned_md(a) < scanned_md(b); });
      const auto same = [&](const PairPoints& a, const PairPoints& b) {
        return survey::is_same_depth(scanned_md(a), scanned_md(b));
      };
      samples.erase(std::unique(samples.begin(), samples.end(), same), samples.end());
      closest = proximity::scan(pair.geometry, direction, 0, 1);
    }
    add_least(pair, direction, closest, samples);
  }
  for (const PairErrors& errors : pair.formulations)
    for (const double md : s_.report_md)
      if (md >= pair.geometry.reference->md(pair.geometry.first))
        add_covariance(pair, errors, "report_md_m", proximity::pair_at(pair.geometry, ScanDirection::reference, md));
  add_published(pair);
  add_warnings(*pair.offset, pair.non_finite);
}

void Tables::add_clearance(const Pair& pair, ScanDirection direction, const std::vector<PairPoints>& points) {
  compare::TableRows& t = clearance_;
  const auto point = [&](const char* which, const proximity::PathPoint& p) {
    const std::string w = which;
    t.number(w + "_north_m", "m", "position, true north", p.position.x());
    t.number(w + "_east_m", "m", "position", p.position.y());
    t.number(w + "_tvd_m", "m", "position, down", p.position.z());
  };
  for (const PairPoints& p : points)
    for (const PairErrors& errors : pair.formulations) {
      const PairClearance c = proximity::clearance_of(pair.geometry, errors, p, true);
      write_wells(t, pair.offset->name, errors.formulation);
      t.word("direction", "the well that the scan goes along; on the other the point is the closest",
             direction_name(direction));
      t.number("ref_md_m", "m", "measured depth on the reference", p.reference.md);
      t.number("offset_md_m", "m", "measured depth on the offset", p.offset.md);
      t.word("end", "where the closest point lies on its well: interior, start or end", end_name(p.end));
      t.count("minimum", "1: the closest point; 2 ...: further local minima of the distance", p.minimum);
      point("ref", p.reference);
      point("offset", p.offset);
      t.number("distance_m", "m", "centre to centre", p.distance);
      t.number("horizontal_bearing_deg", "deg", "from the reference to the offset, from north; none: straight above",
               p.bearing / kDegree);
      t.number("toolface_to_offset_deg", "deg", "direction to the offset seen along the reference, from high side",
               p.toolface / kDegree);
      t.number("sd_reference_m", "m", "pedal radius of the reference along the line between the wells", c.sd_reference);
      t.number("sd_offset_m", "m", "pedal radius of the offset", c.sd_offset);
      t.number("sd_relative_m", "m", "pedal radius of the relative covariance: sd of the distance", c.sd_relative);
      t.number("separation_factor", "1", "(D - R - S_m) / (k sqrt(sd^2 + sigma_pa^2))", c.separation_factor);
      t.number("ellipse_separation_m", "m", "D - R - k sd", c.ellipse_separation);
      t.number("sigma_distance", "1", "D / sd_relative", c.sigma_distance);
      t.number("mahalanobis", "1", "sqrt(d' C_rel^-1 d); inf: d leaves the range of C_rel", c.mahalanobis);
      t.number("ellipsoid_factor", "1", "k at which the ellipsoids touch; of independent wells only",
               c.ellipsoid_factor);
    }
}

void Tables::add_least(const Pair& pair, ScanDirection direction, const std::vector<PairPoints>& stations,
                       const std::vector<PairPoints>& samples) {
  compare::TableRows& t = least_;
  for (const PairErrors& errors : pair.formulations) {
    const std::array<proximity::Least, 3> least =
        proximity::least_clearance(pair.geometry, errors, direction, stations, samples);
    for (std::size_t q = 0; q < least.size(); ++q) {
      const proximity::Least& x = least[q];
      const LeastOf of = proximity::kLeastOf[q];
      const bool is_found = !std::isnan(x.continuous);
      const auto md = [&](double value) { return is_found ? value : kNaN; };
      write_wells(t, pair.offset->name, errors.formulation);
      t.word("direction", "the well that the scan goes along", direction_name(direction));
      t.word("quantity", "what is least", least_name(of));
      t.word("unit", "of the least values", of == LeastOf::distance ? "m" : "1");
      t.number("at_stations", "1", "least value at stations, in the row's unit", x.at_station);
      t.number("stations_ref_md_m", "m", "where, on the reference", md(x.station_pair.reference.md));
      t.number("stations_offset_md_m", "m", "where, on the offset", md(x.station_pair.offset.md));
      t.number("continuous", "1", "least value over all depths, in the row's unit", x.continuous);
      t.number("ref_md_m", "m", "where, on the reference", md(x.pair.reference.md));
      t.number("offset_md_m", "m", "where, on the offset", md(x.pair.offset.md));
      t.word("end", "where that point lies on the well that is not scanned", is_found ? end_name(x.pair.end) : "");
      t.number("distance_m", "m", "centre to centre, there", md(x.pair.distance));
      t.word("rule", "kept: no separation factor below 1; broken: one is; none: no value at some depth",
             of != LeastOf::separation_factor ? ""
             : is_found && x.continuous < 1   ? "broken"
             : !is_found || !x.is_everywhere  ? "none"
                                              : "kept");
      if (of == LeastOf::separation_factor && is_found && direction == ScanDirection::reference)
        add_covariance(pair, errors, "least separation factor", x.pair);
      if (s_.laws.any() && of == LeastOf::separation_factor && is_found && direction == ScanDirection::reference)
        add_tail(pair, errors, x.pair);
    }
  }
}

void Tables::add_tail(const Pair& pair, const PairErrors& errors, const PairPoints& p) {
  const PairClearance c = proximity::clearance_of(pair.geometry, errors, p, false);
  const double sd = std::hypot(c.sd_relative, s_.rule.project_ahead);
  write_tail(pair.offset->name, errors.formulation, p, sd, c.separation_factor,
             proximity::heavy_parts(errors, s_.laws, p, sd));
}

void Tables::write_tail(const std::string& offset, const std::string& formulation, const PairPoints& p, double sd,
                        double factor, const std::vector<stats::HeavyPart>& parts) {
  compare::TableRows& t = tails_;
  double share = 0;
  for (const stats::HeavyPart& part : parts) share += part.weight * part.weight;
  const double k = s_.rule.scale_factor, normal = stats::normal_upper_tail(k),
               probability = stats::beyond(parts, {k})[0] / 2, same = stats::quantile_beyond(parts, 2 * normal),
               same_factor = factor * k / same;
  write_wells(t, offset, formulation);
  t.number("ref_md_m", "m", "measured depth on the reference", p.reference.md);
  t.number("distance_m", "m", "centre to centre", p.distance);
  t.number("sd_m", "m", "sqrt(sd_relative^2 + sigma_pa^2)", sd);
  t.number("heavy_share", "1", "share of its variance that is not normal", share);
  t.number("k", "1", "of the separation rule", k);
  t.number("normal", "1", "probability of an error beyond k sd towards the other well, of a normal distribution",
           normal);
  t.number("probability", "1", "the same with the laws: what a separation factor of 1 stands for", probability);
  t.number("k_same_risk", "1", "k at which that probability is the normal's", same);
  t.number("separation_factor", "1", "of the rule", factor);
  t.number("factor_same_risk", "1", "the same with k_same_risk", same_factor);
  t.word("rule", "kept or broken", factor < 1 ? "broken" : "kept");
  t.word("rule_same_risk", "kept or broken, with k_same_risk", same_factor < 1 ? "broken" : "kept");
}

void Tables::add_covariance(const Pair& pair, const PairErrors& errors, const std::string& where, const PairPoints& p) {
  const Matrix3d r = errors.reference->covariance_at(p.reference.leg, p.reference.share),
                 o = errors.offset->covariance_at(p.offset.leg, p.offset.share),
                 c = proximity::relative_covariance(errors, r, o, p.reference.leg, p.reference.share, p.offset.leg,
                                                    p.offset.share);
  write_covariance(pair.offset->name, errors.formulation, where, p, "relative", c);
  write_covariance(pair.offset->name, errors.formulation, where, p, "reference", r);
  write_covariance(pair.offset->name, errors.formulation, where, p, "offset", o);
}

void Tables::write_covariance(const std::string& offset, const std::string& formulation, const std::string& where,
                              const PairPoints& p, const std::string& of, const Matrix3d& covariance) {
  compare::TableRows& t = covariance_;
  write_wells(t, offset, formulation);
  t.word("where", "report_md_m, or least separation factor", where);
  t.number("ref_md_m", "m", "measured depth on the reference", p.reference.md);
  t.number("offset_md_m", "m", "measured depth on the offset", p.offset.md);
  const Eigen::Vector3d d = p.offset.position - p.reference.position;
  t.number("distance_north_m", "m", "from the reference to the offset", d.x());
  t.number("distance_east_m", "m", "from the reference to the offset", d.y());
  t.number("distance_down_m", "m", "from the reference to the offset", d.z());
  t.word("of", "relative, reference or offset", of);
  t.covariance("nev", "covariance, north, east, vertical (down), true north", covariance);
}

void Tables::add_published(const Pair& pair) {
  for (const Published& p : s_.published) {
    if (p.offset != pair.offset->name) continue;
    const PairPoints points = proximity::pair_at(pair.geometry, p.direction, p.md);
    const PairClearance c = proximity::clearance_of(pair.geometry, pair.formulation(p.formulation), points, true);
    for (const auto& [quantity, value] : p.values)
      published_.push_back({&p, quantity, quantity_of(quantity, points, c), value});
  }
}

void Tables::add_warnings(const Well& w, const std::vector<propagate::NonFiniteTerm>& non_finite) {
  for (compare::Warning& warning : scenario::warnings_of(w, non_finite)) warnings_.push_back(std::move(warning));
}

store::Table Tables::parameters_table() const {
  compare::TableRows t("parameters", "the wells as they were compared");
  const auto row = [&](const Well& w) {
    t.word("well", "name of the well", w.name);
    t.number("slot_north_m", "m", "position of the first station", w.slot.x());
    t.number("slot_east_m", "m", "position of the first station", w.slot.y());
    t.number("slot_down_m", "m", "position of the first station", w.slot.z());
    t.number("hole_diameter_m", "m", "of the hole", w.hole_diameter);
    t.count("stations", "stations of the survey", w.survey.stations.size());
    t.number("first_md_m", "m", "measured depth of the first", w.survey.stations.front().md);
    t.number("last_md_m", "m", "measured depth of the last", w.survey.stations.back().md);
    t.number("kickoff_md_m", "m", "of a sidetrack: down to it, the well is the reference",
             w.kickoff ? w.survey.stations[*w.kickoff].md : kNaN);
    t.word("models", "error models of its survey legs", fmt::format("{}", fmt::join(w.tools.model_names, ", ")));
    t.number("total_nT", "nT", "reference field", w.field.total);
    t.number("dip_deg", "deg", "reference field", w.field.dip / kDegree);
    t.number("declination_deg", "deg", "reference field", w.field.declination / kDegree);
    t.number("scale_factor", "1", "k of the separation rule", s_.rule.scale_factor);
    t.number("surface_margin_m", "m", "S_m of the separation rule", s_.rule.surface_margin);
    t.number("project_ahead_m", "m", "sigma_pa of the separation rule", s_.rule.project_ahead);
  };
  row(s_.reference);
  for (const Well& w : s_.offsets) row(w);
  return t.take();
}

std::vector<store::Table> Tables::take(const Reference& reference) {
  std::vector<store::Table> out;
  add_warnings(reference.well(), reference.non_finite());
  out.push_back(least_.take());
  if (s_.with_rows) out.push_back(clearance_.take());
  out.push_back(covariance_.take([&] { write_covariance("", "", "", {}, "", Matrix3d::Zero()); }));
  if (s_.laws.any()) out.push_back(tails_.take([&] { write_tail("", "", {}, 0, 0, {}); }));
  out.push_back(parameters_table());
  if (s_.with_rows) out.push_back(scenario::paths_table(s_));
  compare::TableRows published("published", "published figures; agrees: within the tolerance");
  const Published none{};
  compare::write_rows(published, published_, [&](const PublishedRow& r) {
    const Published& p = r.published ? *r.published : none;
    write_wells(published, p.offset, p.formulation);
    published.word("direction", "the well that the scan goes along", direction_name(p.direction));
    published.number("md_m", "m", "measured depth on that well", p.md);
    published.word("quantity", "column of the table clearance", r.quantity);
    published.number("analytic", "1", "our value, in the unit of its column", r.analytic);
    published.number("published", "1", "published value", r.value);
    published.number("difference", "1", "analytic - published", r.analytic - r.value);
    published.number("tolerance", "1", "of the difference", p.tolerance);
    published.word("verdict", "agrees or differs",
                   std::abs(r.analytic - r.value) <= p.tolerance ? "agrees" : "differs");
    published.word("expected", "the verdict this row should have", "agrees");
    published.word("note", "where the published value is from", p.source);
  });
  out.push_back(published.take());
  out.push_back(compare::warnings_table(warnings_));
  return out;
}

}  // namespace surveymc::studies::clearance
