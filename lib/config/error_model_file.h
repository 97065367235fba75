#pragma once
/// Error models from TOML files, and from those that come with the program.
#include <memory>
#include <string>
#include <vector>

#include "config/config.h"
#include "config/shipped_models.h"
#include "error_model/model.h"

namespace surveymc::config {

using SharedModel = std::shared_ptr<const error_model::Model>;

/// All models of a file, in its order (docs/results-format.md, "Error model files"). A file is one model:
///   title, source (texts, optional), first_leg = "once" | "doubled",
///   terms = [ { code, function, magnitude, unit, mode } ]
/// or has functions and several models:
///   functions = "file of [[function]] tables, relative to this one"
///   [[function]] name, kind, axis, per_section, depth, inclination, azimuth | lateral, vertical_north, vertical_east
///   [[model]] name, extends, remove, terms, first_leg, inclination_range_deg, east_west_exclusion_deg,
///             parameters, gyro, title, source, prefix, revision, date, tool, note
/// Functions: those of the file, then of its file of functions, then the shipped ones. `catalogue`: where from, for
/// tables. Throws InputError "file:line: key = value: rule" for all that section "Error model files" refuses.
std::vector<SharedModel> read_error_models(ConfigReader document, const std::string& catalogue);

/// The [[function]] tables of a file of functions, which has nothing else.
FunctionTable read_functions(ConfigReader document);

/// The model that comes with the program under this name; `key` of `config` has chosen it.
SharedModel read_shipped_model(ConfigReader& config, const std::string& key, const ShippedModel& shipped);

/// The same without a config.
SharedModel load_shipped_model(const ShippedModel& shipped);

/// The model with its functions as TOML that reads back to the same: one [[model]], nothing extended.
std::string model_text(const error_model::Model& model);

}  // namespace surveymc::config
