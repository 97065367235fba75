#pragma once
/// Tables of where the error models of a well do not hold, for studies that compute beyond their ranges all the same
/// (`error_model.outside_range` = "mark").
#include <string>
#include <vector>

#include "propagate/tool_validity.h"
#include "scenario/error_models.h"
#include "store/table.h"

namespace surveymc::scenario {

/// One row a leg and rule that is not kept, or note.
store::Table validity_table(const survey::Survey& survey, const ToolRuns& tools,
                            const std::vector<propagate::Validity>& validity);

/// A warning that a user must know before using a well's numbers.
struct ValidityWarning {
  std::string severity, message;
};
/// The same but for notes, in words. `well`: its name, where there are several.
std::vector<ValidityWarning> validity_warnings(const survey::Survey& survey, const ToolRuns& tools,
                                               const std::vector<propagate::Validity>& validity,
                                               const std::string& well = "");
/// Table warnings, which `run` prints last. `numbers`: what they are about, "covariances".
store::Table validity_warnings_table(const std::string& numbers, const std::vector<ValidityWarning>& warnings);

}  // namespace surveymc::scenario
