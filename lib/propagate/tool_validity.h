#pragma once
/// Stations at which the error models of a well's tools do not hold, and terms without effect.
#include <cstddef>
#include <string>
#include <vector>

#include "propagate/tool_covariance.h"

namespace surveymc::propagate {

enum class ValidityRule {
  inclination_range,    ///< stations outside of the model's range of inclinations
  east_west_exclusion,  ///< stations too near to horizontal magnetic east or west
  not_finite,           ///< a term has no finite effect there
  zero_term,            ///< a term has no effect at any inclination, azimuth and turn
  function_differs,     ///< an error that a run shares with another (W or G, one code) has another formula there
  note                  ///< what the model's author says
};
/// "inclination range" ...
std::string rule_name(ValidityRule rule);

struct Validity {
  std::size_t run = 0;
  ValidityRule rule = ValidityRule::note;
  std::size_t stations = 0, first = 0, last = 0;  ///< how many, and which
  std::string detail;
};

/// In the order of runs and rules; `latitude` as for tool_covariances. Findings of the covariance itself
/// (not_finite) are not among them.
std::vector<Validity> tool_validity(const survey::Survey& survey, const std::vector<ToolRun>& runs,
                                    const survey::ReferenceField& field, double latitude);
/// NonFiniteTerm as a row of validity.
Validity validity_of(const NonFiniteTerm& term, const std::vector<ToolRun>& runs);

/// True if a model claims to hold at a station: its range of inclinations and its exclusion about magnetic east and
/// west.
bool holds_at(const error_model::Model& model, double inclination, double magnetic_azimuth);

}  // namespace surveymc::propagate
