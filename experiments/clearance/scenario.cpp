#include "clearance/scenario.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/ranges.h>

#include "base/units.h"
#include "compare/annotations.h"
#include "compare/trial_plan.h"
#include "config/meanings.h"
#include "scenario/input_remarks.h"
#include "scenario/reference_laws.h"
#include "survey/minimum_curvature.h"
#include "survey/survey.h"

namespace surveymc::studies::clearance {
namespace {

using error_model::PropagationMode;
using proximity::Interpolation;
using proximity::JoiningSource;
using proximity::ScanDirection;
using proximity::Sharing;

constexpr std::size_t kMostDepths = 200;

void read_reported(config::ConfigReader& c, Scenario& s) {
  if (!c.has("report_md_m")) return;
  const double first = s.reference.survey.stations.front().md, last = s.reference.survey.stations.back().md;
  s.report_md = c.numbers("report_md_m", {}, config::meaning::kReportDepths);
  c.require(s.report_md.size() <= kMostDepths, "report_md_m", fmt::format("must have 1 to {} depths", kMostDepths));
  for (std::size_t i = 0; i < s.report_md.size(); ++i) {
    const std::optional<double> on = survey::depth_on(s.reference.survey, s.report_md[i]);
    c.require(on.has_value(), "report_md_m",
              fmt::format("{:.10g} is not on the reference, which goes from {:.10g} to {:.10g} m", s.report_md[i],
                          first, last));
    s.report_md[i] = *on;
    c.require(i == 0 || survey::is_deeper(s.report_md[i], s.report_md[i - 1]), "report_md_m", "must increase");
  }
}

void read_drawing(config::ConfigReader& c, Scenario& s) {
  Drawing& d = s.drawing;
  std::vector<compare::Row> rows;
  for (const Formulation& f : s.formulations) {
    for (const char* q : kRelativeQuantities) rows.push_back({"relative_position", f.name, q});
    for (const std::string& q : published_quantities()) rows.push_back({"clearance", f.name, q});
  }
  if (c.has("trials"))
    d.trials = static_cast<std::uint64_t>(
        c.integer("trials", 0, 1'000'000'000'000, "wells to draw; needs `report_md_m` and `seed`"));
  d.verdict = compare::read_verdict_rule(c);
  d.annotations = compare::Annotations::read(c, rows);
  if (d.trials == 0) return;
  c.require(d.trials >= 20, "trials", "must be 0 or at least 20");
  c.require(!s.report_md.empty(), "trials", "needs report_md_m: depths of the reference at which wells are drawn");
  d.save_samples =
      static_cast<std::uint64_t>(c.integer("save_samples", 0, 1'000'000, config::meaning::kSaveSamples, 0));
  d.vertical = c.choice("errors.vertical", {"tilt", "azimuth"}, config::meaning::kErrorsVertical, "tilt") == "azimuth"
                   ? propagate::VerticalRule::azimuth
                   : propagate::VerticalRule::tilt;
  std::vector<std::string> names{"own"};
  for (const Formulation& f : s.formulations)
    if (f.kind != Formulation::Kind::zeroed) names.push_back(f.name);
  const std::string drawn = c.listed_name(
      "errors.formulation", names, "\"own\" or a formulation of separation.formulations",
      "by which formulation the drawn wells share draws; 'own': each formulation is compared with draws of its own",
      "own");
  if (drawn != "own") d.formulation = drawn;
}

void read_published_values(config::ConfigReader& c, Scenario& s) {
  std::vector<std::string> offsets, formulations;
  for (const Well& w : s.offsets) offsets.push_back(w.name);
  for (const Formulation& f : s.formulations) formulations.push_back(f.name);
  for (config::ConfigReader& entry : c.tables("published", config::kMeaningElsewhere)) {
    const compare::PublishedEntry given = compare::read_published(entry);
    Published p;
    p.source = given.source;
    p.values = given.values;
    if (entry.choice("table", {"clearance", "relative_position"}, config::kMeaningElsewhere) != "clearance") continue;
    for (const auto& [quantity, value] : p.values) {
      const auto& known = published_quantities();
      entry.require(std::find(known.begin(), known.end(), quantity) != known.end(), "values",
                    fmt::format("must be of {}", fmt::join(known, ", ")));
    }
    p.tolerance = entry.number("tolerance", config::Range::positive(), "largest difference that agrees", 0.0055);
    const bool is_of_offset =
        entry.choice("direction", {"reference", "offset"}, "the well that is scanned", "reference") == "offset";
    entry.text("offset", config::kMeaningElsewhere);
    entry.text("formulation", config::kMeaningElsewhere);
    entry.number("md_m", config::Range::non_negative(), config::kMeaningElsewhere);
    if (!given.here) continue;  // another point may have other wells
    p.offset = entry.listed_name("offset", offsets, "the name of an [[offset]]", "the offset that is meant");
    p.formulation = entry.listed_name("formulation", formulations, "a formulation of separation.formulations",
                                      config::kMeaningElsewhere);
    const auto at = static_cast<std::size_t>(std::find(offsets.begin(), offsets.end(), p.offset) - offsets.begin());
    const auto f = std::find(formulations.begin(), formulations.end(), p.formulation) - formulations.begin();
    entry.require(s.formulations[static_cast<std::size_t>(f)].is_for(s.offsets[at]), "formulation",
                  "is for sidetracks: this offset has no kickoff_md_m");
    if (is_of_offset) p.direction = ScanDirection::offset;
    const survey::Survey& scanned = p.direction == ScanDirection::reference ? s.reference.survey : s.offsets[at].survey;
    const std::optional<std::size_t> kickoff = s.offsets[at].kickoff;
    const double first = scanned.stations[kickoff.value_or(0)].md, last = scanned.stations.back().md;
    const std::optional<double> on = survey::depth_on(
        scanned,
        entry.number("md_m", config::Range::non_negative(), "measured depth of the row, on the well that is scanned"));
    entry.require(on && *on >= first, "md_m", fmt::format("must be in [{:.10g}, {:.10g}]", first, last));
    p.md = *on;
    s.published.push_back(std::move(p));
  }
}

}  // namespace

const std::vector<std::string>& published_quantities() {
  static const std::vector<std::string> names{
      "ref_md_m",       "offset_md_m", "distance_m",      "horizontal_bearing_deg", "toolface_to_offset_deg",
      "sd_reference_m", "sd_offset_m", "sd_relative_m",   "separation_factor",      "ellipse_separation_m",
      "sigma_distance", "mahalanobis", "ellipsoid_factor"};
  return names;
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  static_cast<scenario::WellPairs&>(s) = scenario::read_well_pairs(c);
  s.seed = seed;
  s.directions = {ScanDirection::reference};
  if (c.choice("scan.direction", {"reference", "both"}, "'both': the offset is scanned, too, which finds other pairs",
               "reference") == "both")
    s.directions.push_back(ScanDirection::offset);
  s.step = c.number("scan.step_m", config::Range::non_negative(),
                    "further scanned points, so far apart from the first station on; 0: stations alone", 0);
  c.require(s.step == 0 || s.step >= 0.01, "scan.step_m", "must be 0 (stations alone) or at least 0.01");
  s.keep = c.number("scan.keep", config::Range{1, kInfinity, false, false},
                    "list local minima of the distance, too, up to so many times the least", 1);
  s.with_rows = c.choice("output.clearance", {"all", "none"}, "'none': without the tables `clearance` and `paths`",
                         "all") == "all";
  read_reported(c, s);
  read_published_values(c, s);
  scenario::scale_models(c, s);
  s.laws = scenario::read_reference_laws(c, {.sizes = false});
  std::vector<const scenario::ToolRuns*> tools{&s.reference.tools};
  for (const scenario::SurveyedWell& offset : s.offsets) tools.push_back(&offset.tools);
  scenario::warn_of_idle_laws(c, s.laws, tools, false);
  for (const auto& e : s.laws.elements)
    c.require(!e.law || e.law->is_symmetric(), "reference_law",
              "\"asymmetric_nig\" has a tail towards the other well and another one away from it: use a symmetric law "
              "here");
  read_drawing(c, s);
  c.require(!s.laws.any() || s.drawing.trials == 0, "trials", "draws normal errors: not together with reference_law");
  if (s.drawing.trials > 0) scenario::require_few_disturbed(c, s);
  if (const auto& d = s.reference.disturbance; d && d->process.kind != disturbance::Kind::ar1) {
    c.require(s.drawing.trials == 0, "trials", "draws normal errors, and of the disturbances only \"ar1\" is normal");
    c.require(!s.laws.any(), "disturbance.kind",
              "only \"ar1\" is normal: of another disturbance the table `tails` has no prediction");
  }
  c.finish();
  return s;
}

}  // namespace surveymc::studies::clearance
