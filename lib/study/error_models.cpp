#include "study/error_models.h"

#include <algorithm>

#include "base/units.h"
#include "config/error_model_file.h"

namespace surveymc::study {

NamedErrorModel read_error_model_choice(config::ConfigReader& c) {
  if (c.has("error_model.file")) {
    if (c.has("error_model.name")) c.fail("error_model.name", "not together with error_model.file");
    return {c.text("error_model.file"), config::read_error_model(c.toml("error_model.file"))};
  }
  std::vector<std::string> names;
  for (const config::InputText& model : config::shipped_error_models()) names.push_back(model.path);
  const std::string name = c.choice("error_model.name", names);
  const config::InputText& shipped = config::shipped_error_models()[static_cast<std::size_t>(
      std::find(names.begin(), names.end(), name) - names.begin())];
  return {name, config::read_error_model(c.toml("error_model.name", {"<shipped>/" + name + ".toml", shipped.text}))};
}

namespace {

/// Depth at which a leg begins, in metres.
double read_from_md(config::ConfigReader& leg, std::string& key) {
  key = leg.has("from_md_ft") ? "from_md_ft" : "from_md_m";
  if (key == "from_md_m") return leg.number(key, config::Range::non_negative());
  if (leg.has("from_md_m")) leg.fail("from_md_m", "not together with from_md_ft");
  return kFoot * leg.number(key, config::Range::non_negative());
}

}  // namespace

ToolRuns read_tool_runs(config::ConfigReader& c, const survey::Survey& survey) {
  constexpr double kSameDepth = 1e-6;  // m: a depth in feet may be written in metres, too
  ToolRuns out;
  NamedErrorModel model = read_error_model_choice(c);
  out.legs.push_back({1, model.model});
  out.model_names.push_back(model.name);
  out.from_md.push_back(survey.stations.front().md);
  for (config::ConfigReader& leg : c.tables("leg")) {
    std::string key;
    const double from = read_from_md(leg, key);
    if (leg.has("error_model")) model = read_error_model_choice(leg);
    const auto first = std::find_if(survey.stations.begin() + 1, survey.stations.end(),
                                    [&](const survey::Station& s) { return s.md > from + kSameDepth; });
    leg.require(first != survey.stations.end(), key, "no station is deeper");
    const int index = static_cast<int>(first - survey.stations.begin());
    leg.require(index > out.legs.back().first, key, "the leg before has no station: legs must be in order of depth");
    out.legs.push_back({index, model.model});
    out.model_names.push_back(model.name);
    out.from_md.push_back(from);
  }
  return out;
}

}  // namespace surveymc::study
