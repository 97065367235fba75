#pragma once
/// Finds surveys that are valid, but look like a mistake.
#include <string>
#include <vector>

#include "config/input_table.h"
#include "survey/survey.h"

namespace surveymc::config {

/// Something unusual in a survey file.
struct SurveyFinding {
  bool is_refused = false;  ///< so unusual that the user has to say it is meant; else a warning
  std::string place;        ///< "path:line"
  std::string value;        ///< "column = value"; "" if it is about whole columns
  std::string text;         ///< what is unusual
  std::string way_out;      ///< what to look at

  /// "path:line: column = value: what is unusual: what to look at"
  std::string in_words() const;
};

/// Unusual values in `table`, from which survey_from_table() has made `survey`. Refused:
///   angles that look like radians; an azimuth outside [0, 360]; a negative measured depth, or one beyond 16 km, which
///   no well has; a hole that turns back (by more than 179 degrees between neighbours).
/// Warned of: azimuths alone that may be radians; a dogleg of more than 30 deg/30 m, which no tool drills (and 3
/// degrees in all, so that stations close to each other do not count their noise); a step in depth that looks like a
/// typing error, thirty times the usual one and more than 1.5 km.
std::vector<SurveyFinding> unusual_in_survey(const InputTable& table, const survey::Survey& survey);

}  // namespace surveymc::config
