#pragma once
/// Which error model each part of a survey has: the keys that studies of covariance models share.
#include <optional>
#include <string>
#include <vector>

#include "config/config.h"
#include "config/error_model_file.h"
#include "propagate/tool_covariance.h"
#include "propagate/tool_validity.h"
#include "propagate/well_errors.h"

namespace surveymc::scenario {

/// The model that `config` names, and what it was called.
struct NamedErrorModel {
  std::string name;  ///< as in the config: of a shipped model, of a file, or "file: name"
  config::SharedModel model;
};

/// `error_model = NAME`, `[error_model] name` (a shipped model: "MWD+IFR1" or "owsg_a_rev5.1/MWD+IFR1") or `file`, with
/// `name` if the file has several; of the whole config or of a [[leg]].
NamedErrorModel read_error_model_choice(config::ConfigReader& config);

/// Tool runs (ISCWSA: survey legs): the first with `[error_model]` from the tie-on, the next ones each from a
/// `[[leg]] from_md_m or from_md_ft, error_model (the one before)`. A run has the stations deeper than its `from`.
struct ToolRuns {
  std::vector<propagate::ToolRun> runs;
  std::vector<std::string> model_names;
  std::vector<double> from_md;  ///< m
};
/// `fallback`: the model of the first run where the config names none.
ToolRuns read_tool_runs(config::ConfigReader& config, const survey::Survey& survey,
                        const std::optional<NamedErrorModel>& fallback = std::nullopt);

/// The models of all runs.
std::vector<config::SharedModel> models_of(const ToolRuns& tools);

/// True if a term of any run has this code.
bool has_source(const ToolRuns& tools, const std::string& code);

/// `field.latitude_deg` in rad: required where a formula of a model has Latitude, else NaN where it is not given.
double read_latitude(config::ConfigReader& config, const std::vector<config::SharedModel>& models);

/// Warns of terms of the user's own models that move nothing at any inclination and azimuth, in this field.
void warn_of_idle_terms(config::ConfigReader& config, const ToolRuns& tools, const survey::ReferenceField& field,
                        double latitude);

/// `error_model.outside_range` = "mark" (default) or "refuse": stations at which a model does not hold are listed, or
/// refused by InputError with the first station and the range. `well`: its name, where there are several.
void read_outside_range(config::ConfigReader& config, const survey::Survey& survey,
                        const std::vector<propagate::ToolRun>& runs, const std::vector<propagate::Validity>& validity,
                        const std::string& well = "");

/// Fails at `place`, the model's, where a source has no finite effect at a station down to `last`: the well cannot be
/// drawn there. `well`: its name, where there are several.
void require_drawable(const config::ConfigPlace& place, const propagate::WellErrors& errors, std::size_t last,
                      const std::string& well = "");

}  // namespace surveymc::scenario
