#include "cli/commands.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "base/error.h"
#include "base/units.h"
#include "cli/exit_codes.h"
#include "cli/file_kind.h"
#include "config/error_model_file.h"
#include "config/suggest.h"

namespace surveymc::cli {
namespace {

std::string list_of(const std::vector<config::SharedModel>& models) {
  std::size_t widest = 0;
  for (const config::SharedModel& m : models) widest = std::max(widest, m->name.size());
  std::string out, catalogue;
  for (const config::SharedModel& m : models) {
    if (m->catalogue != catalogue) out += fmt::format("{}{}:\n", out.empty() ? "" : "\n", m->catalogue);
    catalogue = m->catalogue;
    std::string holds = fmt::format("{:.4g}-{:.4g} deg", m->inclination_min / kDegree, m->inclination_max / kDegree);
    if (m->east_west_exclusion > 0) holds += fmt::format(", not {:.3g} deg from E/W", m->east_west_exclusion / kDegree);
    out += fmt::format("  {:<{}}  {:>2} terms  {:<32} {}\n", m->name, widest, m->terms.size(), holds, m->title);
  }
  return out;
}

std::vector<config::SharedModel> models_of(const ModelsArguments& a) {
  if (!a.file.empty()) return config::read_error_models(config::ConfigReader::of_file(a.file), a.file);
  std::vector<config::SharedModel> all;
  if (!a.name.empty()) {
    const config::ShippedModel* shipped = config::find_shipped_model(a.name);
    const FileKind kind = shipped ? FileKind::unknown : kind_of_file(a.name);
    require_usage(kind == FileKind::unknown, "models {}: must be the name of an error model, but this is {}", a.name,
                  what_to_do(a.name, kind));
    require_usage(shipped != nullptr, "models {}: unknown error model: {}", a.name,
                  config::shipped_model_suggestion(a.name));
    return {config::load_shipped_model(*shipped)};
  }
  for (const config::ShippedModel& m : config::shipped_models()) all.push_back(config::load_shipped_model(m));
  return all;
}

}  // namespace

std::string models_text(const ModelsArguments& a) {
  const std::vector<config::SharedModel> models = models_of(a);
  if (a.name.empty()) return list_of(models);
  const std::string own = a.file.empty() ? a.name.substr(a.name.find('/') + 1) : a.name;
  for (const config::SharedModel& m : models)
    if (m->name == own)
      return fmt::format(
          "# Error model {} of {}. Edit it, and name the file in a config: error_model.file = \"mine.toml\"\n{}",
          m->name, m->catalogue, config::model_text(*m));
  std::vector<std::string> names;
  for (const config::SharedModel& m : models) names.push_back(m->name);
  throw InputError(
      fmt::format("models {}: {} has no model of this name{}", a.name, a.file, config::suggestion(a.name, names)));
}

}  // namespace surveymc::cli
