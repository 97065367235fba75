#include "error_model_monte_carlo/study.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/units.h"
#include "compare/trial_plan.h"
#include "compare/verdict_stop.h"
#include "config/meanings.h"
#include "events/linear_event.h"
#include "propagate/disturbed_errors.h"
#include "propagate/source_moments.h"
#include "scenario/disturbance.h"
#include "scenario/reference_laws.h"
#include "scenario/scenario.h"
#include "survey/minimum_curvature.h"
#include "survey/survey.h"

namespace surveymc::studies::error_model_monte_carlo {
namespace {

constexpr std::size_t kMostDepths = 50;

/// `[well] inclination_deg, azimuth_deg, length_m, vertical_m, build_deg_per_30m, spacing_m`: a made-up well, vertical,
/// built and held, instead of a survey.
survey::Survey read_made_well(config::ConfigReader& c) {
  const double inclination = c.number("well.inclination_deg", config::Range::closed(0, 180),
                                      "a well in place of `survey`: inclination to which it builds"),
               azimuth = c.number("well.azimuth_deg", config::Range::closed(-360, 360), "azimuth of the well"),
               vertical =
                   c.number("well.vertical_m", config::Range::non_negative(), "length of the vertical part", 900),
               build = c.number("well.build_deg_per_30m", config::Range::positive(), "build rate", 3),
               length = c.number("well.length_m", config::Range::positive(),
                                 "measured depth of the end, a multiple of the spacing"),
               spacing = c.number("well.spacing_m", config::Range::positive(), "distance of the stations", 30);
  const double intervals = length / spacing;
  c.require(intervals < 100'000.5, "well.spacing_m", "more than 100000 stations");
  c.require(std::abs(intervals - std::round(intervals)) < 1e-6 && intervals > 0.5, "well.spacing_m",
            "must divide length_m into whole intervals");
  c.require(build / 30 * spacing < 90, "well.build_deg_per_30m", "more than 90 deg between two stations");
  survey::Survey s;
  for (int k = 0; k <= static_cast<int>(std::lround(intervals)); ++k) {
    const double md = spacing * k;
    s.stations.push_back(
        {md, std::clamp((md - vertical) * build / 30, 0.0, inclination) * kDegree, azimuth * kDegree, 0});
  }
  return s;
}

std::vector<double> read_report_depths(config::ConfigReader& c, const survey::Survey& survey) {
  const bool feet = c.has("report_md_ft");
  const std::string key = feet ? "report_md_ft" : "report_md_m";
  const double first = survey.stations.front().md, last = survey.stations.back().md;
  if (!c.has(key)) return {last};
  c.require(!feet || !c.has("report_md_m"), key, "not together with report_md_m");
  std::vector<double> out;
  for (const double depth : c.numbers(key, {}, config::meaning::kReportDepths)) {
    const std::optional<double> md = survey::depth_on(survey, depth * (feet ? kFoot : 1));
    c.require(md && *md > first, key,
              fmt::format("{} is off the survey, which goes from {} to {} m, or its tie-on, which has no error",
                          config::format_number(depth), config::format_number(first), config::format_number(last)));
    c.require(out.empty() || survey::is_deeper(*md, out.back()), key, "must increase");
    out.push_back(*md);
  }
  c.require(out.size() <= kMostDepths, key, fmt::format("must have 1 to {} depths", kMostDepths));
  return out;
}

/// Quadrature takes sources of a few draws: names the others.
void note_left_out(const config::ConfigReader& c, const Scenario& s) {
  const propagate::WellErrors errors =
      propagate::well_errors(s.survey, s.tvd, s.tools.runs, s.field, s.latitude, s.multiplier, s.vertical);
  std::vector<std::string> sources;
  for (const propagate::ErrorSource& source : errors.sources)
    if (!source.draws.empty() && !is_for_quadrature(source))
      sources.push_back(fmt::format("{} ({})", source.code, error_model::mode_letter(source.mode)));
  if (!sources.empty())
    c.note(fmt::format("errors.sources = \"quadrature\" leaves out {}: random, or more than {} draws each",
                       fmt::join(sources, ", "), propagate::kMostQuadratureDraws));
}

void read_sources(config::ConfigReader& c, Scenario& s) {
  const std::string key = "errors.sources";
  std::vector<std::string> words{"total"};
  if (c.has(key))
    words = c.texts(
        key,
        "what is drawn: 'total': all sources together; 'each': all, and each alone; a list of codes: all, and these, "
        "each alone; 'quadrature': each source of at most three draws alone, exactly and without trials");
  else
    c.text(key, config::kMeaningElsewhere, "total");
  const std::string& word = words.front();
  if (words.size() == 1 && (word == "total" || word == "each" || word == "quadrature")) {
    s.sources = word == "total" ? Sources::total : word == "each" ? Sources::each : Sources::quadrature;
    if (s.sources == Sources::quadrature) note_left_out(c, s);
    return;
  }
  s.sources = Sources::listed;
  for (const std::string& code : words) {
    c.require(
        scenario::has_source(s.tools, code), key,
        fmt::format("no model here has \"{}\"; must be \"total\", \"each\", \"quadrature\", or a list of codes of "
                    "the model (surveymc models shows them)",
                    code));
    c.require(std::count(words.begin(), words.end(), code) == 1, key, fmt::format("\"{}\" is there twice", code));
  }
  s.listed = words;
}

/// `laws`: the predictions beyond first order are of normal errors.
std::vector<std::string> read_formulations(config::ConfigReader& c, bool laws) {
  if (!c.has("formulations")) {
    if (laws) return {"iscwsa", "minimum_curvature"};
    return {"iscwsa", "minimum_curvature", "second"};
  }
  const std::vector<std::string> out =
      c.texts("formulations", "predictions that are compared; without it iscwsa, minimum_curvature and second");
  for (const std::string& f : out) {
    c.require(std::find(kFormulations.begin(), kFormulations.end(), f) != kFormulations.end(), "formulations",
              fmt::format("\"{}\": must be of \"{}\"", f, fmt::join(kFormulations, "\", \"")));
    c.require(std::count(out.begin(), out.end(), f) == 1, "formulations", fmt::format("\"{}\" is there twice", f));
    c.require(!laws || f == "iscwsa" || f == "minimum_curvature", "formulations",
              fmt::format("\"{}\" is of normal errors: not together with reference_law", f));
  }
  return out;
}

}  // namespace

namespace {

/// The rest of a config with `[[event]]`.
void read_event_scenario(config::ConfigReader& c, Scenario& s) {
  c.require(s.sources == Sources::total, "errors.sources", "must be \"total\" where [[event]] is given");
  c.require(!s.disturbance || s.disturbance->process.kind == disturbance::Kind::ar1, "disturbance.kind",
            "events are regions of normals, and only \"ar1\" is normal: must be \"ar1\" where [[event]] is given");
  events::refuse_beside_events(c, {"formulations", "tails"});
  s.report_md = read_report_depths(c, s.survey);
  const std::string key = c.has("report_md_ft") ? "report_md_ft" : "report_md_m";
  c.require(s.report_md.size() == 1 && survey::station_at(s.survey, s.report_md.front()), key,
            "must be one station where [[event]] is given");
  s.event_run = events::read_event_run(c);
  s.annotations = events::read_event_annotations(c, events::linear_formulations(s.laws.any()));
  std::vector<events::EventQuantity> quantities;
  for (std::size_t i = 0; i < kEventQuantities.size(); ++i)
    quantities.push_back(
        {kEventQuantities[i], i < kFirstInSd ? events::EventLimits::either : events::EventLimits::only_above});
  s.events = events::read_events(c, quantities);
  c.finish();
}

}  // namespace

bool is_for_quadrature(const propagate::ErrorSource& source) {
  return source.mode != error_model::PropagationMode::random && source.draws.size() <= propagate::kMostQuadratureDraws;
}

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.field = scenario::read_field(c);
  const bool made = c.has("well.inclination_deg") || c.has("well.length_m");
  if (made) {
    c.require(!c.has("survey.file"), "survey.file", "not together with [well], a made-up one");
    s.survey = read_made_well(c);
    s.tvd = survey::true_vertical_depths(s.survey);
  } else {
    s.survey = scenario::read_survey(c, s.field, false);
    s.tvd = scenario::read_true_vertical_depths(c, s.survey);
  }
  s.tools = scenario::read_tool_runs(c, s.survey);
  s.latitude = scenario::read_latitude(c, scenario::models_of(s.tools));
  s.disturbance = scenario::read_disturbance(c, s.survey);
  if (s.disturbance)
    s.tools.runs = c.place("disturbance.kind").with_place([&] {
      std::vector<propagate::ToolRun> runs = propagate::disturbed_runs(s.tools.runs, *s.disturbance, s.field);
      propagate::require_few_draws(runs, s.survey.stations.size());
      return runs;
    });
  s.validity = propagate::tool_validity(s.survey, s.tools.runs, s.field, s.latitude);
  scenario::read_outside_range(c, s.survey, s.tools.runs, s.validity);
  scenario::warn_of_idle_terms(c, s.tools, s.field, s.latitude);
  s.model_place = c.place("error_model");
  s.multiplier = c.number("errors.multiplier", {0, 1000, true, false}, config::meaning::kErrorsMultiplier, 1);
  s.vertical = c.choice("errors.vertical", {"tilt", "azimuth"}, config::meaning::kErrorsVertical, "tilt") == "tilt"
                   ? propagate::VerticalRule::tilt
                   : propagate::VerticalRule::azimuth;
  read_sources(c, s);
  s.laws = scenario::read_reference_laws(c, {});
  scenario::warn_of_idle_laws(c, s.laws, {&s.tools});
  c.require(!s.laws.any() || s.samples(), "errors.sources",
            "\"quadrature\" is of normal errors: not together with reference_law");
  if (s.samples() && !events::has_events(c)) s.tails = compare::read_tail_rule(c, s.laws);
  scenario::set_beside_laws(c, s.disturbance, s.laws, s.tails);
  if (events::has_events(c)) {
    read_event_scenario(c, s);
    return s;
  }
  s.formulations = read_formulations(c, s.laws.any());
  s.antithetic = c.boolean("antithetic", config::meaning::kAntithetic, false);
  c.require(!s.antithetic || !s.disturbance || s.disturbance->symmetric(), "antithetic",
            "a disturbance of kind \"series\" or \"diurnal\" and its negative are not equally likely");
  if (s.samples()) {
    s.verdict = compare::read_verdict_rule(c);
    s.trial_plan = compare::read_verdict_plan(c, ErrorModelMonteCarlo::rows_of(s), s.verdict, {20});
    s.save_samples =
        static_cast<std::uint64_t>(c.integer("save_samples", 0, 1'000'000, config::meaning::kSaveSamples, 0));
    c.require(!s.antithetic || s.trial_plan.trials % 2 == 0, s.trial_plan.looks.empty() ? "trials" : "stop.max_trials",
              "must be even where antithetic = true: trials come in pairs");
  } else {
    if (c.has("stop")) c.fail("stop", "errors.sources = \"quadrature\" draws nothing: leave it out");
    if (c.has("trials"))
      c.integer("trials", 0, 1'000'000'000'000,
                config::kMeaningElsewhere);  // any config may have it; nothing is drawn here
    if (c.has("save_samples")) c.integer("save_samples", 0, 1'000'000, config::kMeaningElsewhere);
  }
  s.report_md = read_report_depths(c, s.survey);
  if (!s.samples()) s.verdict = compare::read_verdict_rule(c);
  s.annotations = compare::Annotations::read(c, ErrorModelMonteCarlo::rows_of(s));
  c.finish();
  return s;
}

}  // namespace surveymc::studies::error_model_monte_carlo
