#pragma once
/// Which error model each part of a survey has: the keys that studies of covariance models share.
#include <vector>

#include "config/config.h"
#include "propagate/iscwsa_covariance.h"

namespace surveymc::study {

/// The model that `config` names, and what it was called.
struct NamedErrorModel {
  std::string name;  ///< as in the config: of a shipped model, or of a file
  propagate::ErrorModel model;
};

/// `error_model = NAME`, `[error_model] name` (a shipped model) or `file`, of the whole config or of a [[leg]].
NamedErrorModel read_error_model_choice(config::ConfigReader& config);

/// Survey legs: the first with `[error_model]` from the tie-on, the next ones each from a
/// `[[leg]] from_md_m or from_md_ft, error_model (the one before)`. A leg has the stations deeper than its `from`.
struct ToolRuns {
  std::vector<propagate::ToolRun> legs;
  std::vector<std::string> model_names;
  std::vector<double> from_md;  ///< m
};
ToolRuns read_tool_runs(config::ConfigReader& config, const survey::Survey& survey);

}  // namespace surveymc::study
