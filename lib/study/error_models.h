#pragma once
/// Which error model each part of a survey has: the keys that studies of covariance models share.
#include <vector>

#include "config/config.h"
#include "propagate/survey_errors.h"

namespace surveymc {

/// The model that `config` names, and what it was called.
struct NamedErrorModel {
  std::string name;  ///< as in the config: of a shipped model, or of a file
  ErrorModel model;
};

/// `error_model = NAME`, `[error_model] name` (a shipped model) or `file`, of the whole config or of a [[leg]].
NamedErrorModel read_error_model_choice(ConfigReader& config);

/// Survey legs: the first with `[error_model]` from the tie-on, the next ones each from a
/// `[[leg]] from_md_m or from_md_ft, error_model (the one before)`. A leg has the stations deeper than its `from`.
struct SurveyLegs {
  std::vector<SurveyLeg> legs;
  std::vector<std::string> model_names;
  std::vector<double> from_md;  ///< m
};
SurveyLegs read_survey_legs(ConfigReader& config, const Survey& survey);

}  // namespace surveymc
