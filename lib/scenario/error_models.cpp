#include "scenario/error_models.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/units.h"
#include "config/meanings.h"
#include "error_model/model_graph.h"
#include "survey/survey.h"

namespace surveymc::scenario {

namespace {

/// The model of a file that `error_model.name` names, or its only one.
NamedErrorModel read_model_of_file(config::ConfigReader& c) {
  const std::string file = c.text("error_model.file", config::kMeaningElsewhere);
  const std::vector<config::SharedModel> models = config::read_error_models(
      c.toml("error_model.file", "file of an error model of your own, beside or in place of `error_model.name`"), file);
  if (!c.has("error_model.name")) {
    std::string names;
    for (const config::SharedModel& m : models) names += (names.empty() ? "\"" : ", \"") + m->name + "\"";
    c.require(models.size() == 1, "error_model.file",
              fmt::format("has {} models: choose one with error_model.name, of {}", models.size(), names));
    return {file, models.front()};
  }
  std::vector<std::string> names;
  for (const config::SharedModel& m : models) names.push_back(m->name);
  const std::string name = c.text(
      "error_model.name", config::kMeaningElsewhere);  // not choice(): `surveymc keys` would list names of an example
  const auto found = std::find(names.begin(), names.end(), name);
  c.require(found != names.end(), "error_model.name",
            fmt::format("must be {}\"{}\"", names.size() > 1 ? "one of " : "", fmt::join(names, "\", \"")));
  const auto at = static_cast<std::size_t>(found - names.begin());
  return {file + ": " + name, models[at]};
}

}  // namespace

NamedErrorModel read_error_model_choice(config::ConfigReader& c) {
  if (c.has("error_model.file")) return read_model_of_file(c);
  const std::string name = c.text("error_model.name",
                                  "shipped error model (`surveymc models`), with its catalogue if one likes "
                                  "('owsg_a_rev5.1/MWD+IFR1'), or the one of several in `error_model.file`");
  const config::ShippedModel* shipped = config::find_shipped_model(name);
  if (shipped == nullptr) c.fail("error_model.name", "unknown error model: " + config::shipped_model_suggestion(name));
  return {name, config::read_shipped_model(c, "error_model.name", *shipped)};
}

namespace {

constexpr std::string_view kFromDepth =
    "measured depth: deeper stations are measured with this tool; legs are in order, and without `error_model` have "
    "that of the leg before";

/// Depth at which a leg begins, in metres.
double read_from_md(config::ConfigReader& leg, std::string& key) {
  key = leg.has("from_md_ft") ? "from_md_ft" : "from_md_m";
  if (key == "from_md_m") return leg.number(key, config::Range::non_negative(), kFromDepth);
  if (leg.has("from_md_m")) leg.fail("from_md_m", "not together with from_md_ft");
  return kFoot * leg.number(key, config::Range::non_negative(), kFromDepth);
}

}  // namespace

ToolRuns read_tool_runs(config::ConfigReader& c, const survey::Survey& survey,
                        const std::optional<NamedErrorModel>& fallback) {
  ToolRuns out;
  NamedErrorModel model = fallback && !c.has("error_model") ? *fallback : read_error_model_choice(c);
  out.runs.push_back({1, model.model});
  out.model_names.push_back(model.name);
  out.from_md.push_back(survey.stations.front().md);
  for (config::ConfigReader& leg : c.tables("leg", "further tools, from a depth on")) {
    std::string key;
    const double from = read_from_md(leg, key);
    if (leg.has("error_model")) model = read_error_model_choice(leg);
    const auto first = std::find_if(survey.stations.begin() + 1, survey.stations.end(),
                                    [&](const survey::Station& s) { return survey::is_deeper(s.md, from); });
    leg.require(first != survey.stations.end(), key, "no station is deeper");
    const int index = static_cast<int>(first - survey.stations.begin());
    leg.require(index > out.runs.back().first, key, "the leg before has no station: legs must be in order of depth");
    out.runs.push_back({index, model.model});
    out.model_names.push_back(model.name);
    out.from_md.push_back(from);
  }
  return out;
}

std::vector<config::SharedModel> models_of(const ToolRuns& tools) {
  std::vector<config::SharedModel> out;
  for (const propagate::ToolRun& run : tools.runs) out.push_back(run.model);
  return out;
}

bool has_source(const ToolRuns& tools, const std::string& code) {
  for (const propagate::ToolRun& run : tools.runs)
    for (const error_model::Term& term : run.model->terms)
      if (term.code == code) return true;
  return false;
}

double read_latitude(config::ConfigReader& c, const std::vector<config::SharedModel>& models) {
  if (c.has("field.latitude_deg"))
    return c.number("field.latitude_deg", config::Range::closed(-90, 90), config::meaning::kLatitude) * kDegree;
  for (const config::SharedModel& m : models)
    for (const error_model::Term& t : m->terms)
      if (t.function->names(error_model::Variable::latitude))
        c.fail("field.latitude_deg", fmt::format("missing: {} of {} needs the latitude", t.code, m->name));
  return kNaN;
}

void warn_of_idle_terms(config::ConfigReader& c, const ToolRuns& tools, const survey::ReferenceField& field,
                        double latitude) {
  for (std::size_t r = 0; r < tools.runs.size(); ++r) {
    // Shipped models are as published, magnitudes of 0 among them: the table `validity` lists those.
    if (config::find_shipped_model(tools.model_names[r]) != nullptr) continue;
    const error_model::Model& m = *tools.runs[r].model;
    const error_model::Surroundings here =
        error_model::surroundings_of(m.parameters, field.dip, field.total, field.gravity, latitude);
    for (const error_model::Term& t : m.terms)
      if (error_model::is_without_effect(t, here))
        c.warn_at(fmt::format("{}: term {}", tools.model_names[r], t.code),
                  fmt::format("magnitude = {}, function = {}", config::format_number(t.magnitude), t.function->name),
                  "has no effect at any inclination and azimuth", "take it out, or give it another function");
  }
}

void read_outside_range(config::ConfigReader& c, const survey::Survey& survey,
                        const std::vector<propagate::ToolRun>& runs, const std::vector<propagate::Validity>& validity,
                        const std::string& well) {
  if (c.choice("error_model.outside_range", {"mark", "refuse"}, config::meaning::kOutsideRange, "mark") == "mark")
    return;
  for (const propagate::Validity& v : validity)
    if (v.rule == propagate::ValidityRule::inclination_range || v.rule == propagate::ValidityRule::east_west_exclusion)
      c.fail("error_model.outside_range", fmt::format("{}{}{}: station at md {} m: {}", well, well.empty() ? "" : ": ",
                                                      runs[v.run].model->name, survey.stations[v.first].md, v.detail));
}

void require_drawable(const config::ConfigPlace& place, const propagate::WellErrors& errors, std::size_t last,
                      const std::string& well) {
  for (std::size_t k = 0; k <= last; ++k)
    for (const propagate::DrawEffect& e : errors.at[k])
      if (std::isnan(e.depth))
        place.fail(fmt::format(
            "{}{}{} has no finite effect at {} m, so that it cannot be drawn: end the survey above, or leave it out",
            well, well.empty() ? "" : ": ", errors.sources[errors.draws[e.draw].source].code,
            config::format_number(errors.survey.stations[k].md)));
}

}  // namespace surveymc::scenario
