#pragma once
/// Tables of where the error models of a well do not hold, for studies that compute beyond their ranges all the same
/// (`error_model.outside_range` = "mark").
#include <string>
#include <vector>

#include "compare/warnings.h"
#include "propagate/tool_validity.h"
#include "scenario/error_models.h"
#include "store/table.h"

namespace surveymc::scenario {

/// One row a leg and rule that is not kept, or note.
store::Table validity_table(const survey::Survey& survey, const ToolRuns& tools,
                            const std::vector<propagate::Validity>& validity);

/// Warnings of where they do not hold: the rows of validity_table() but for notes. `well`: its name, where there are
/// several.
std::vector<compare::Warning> validity_warnings(const survey::Survey& survey, const ToolRuns& tools,
                                                const std::vector<propagate::Validity>& validity,
                                                const std::string& well = "");

}  // namespace surveymc::scenario
