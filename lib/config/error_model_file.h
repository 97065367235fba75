#pragma once
/// Error models from TOML files, and the models that come with the program.
#include <string>
#include <vector>

#include "config/config.h"
#include "propagate/error_model.h"

namespace surveymc::config {

/// The model in a file (docs/results-format.md, "Error model files"):
///   title, source (texts, optional)
///   first_leg = "once" | "doubled"
///   terms = [ { code, function, magnitude, unit, mode }, ... ]
/// Throws InputError "file:line: key = value: rule" for an unknown function, mode or key, a unit that does not measure
/// what the function needs, a code that is there twice, a magnitude that is negative or not a number, no terms.
propagate::ErrorModel read_error_model(ConfigReader document);

/// configs/error_models as it was when the program was built; `path` is the file's name without folder and ending.
const std::vector<InputText>& shipped_error_models();

}  // namespace surveymc::config
