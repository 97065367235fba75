#pragma once
/// Where the error models of a well do not hold, as tables: what a study says that computes beyond their ranges all the
/// same (`error_model.outside_range` = "mark").
#include <vector>

#include "propagate/tool_validity.h"
#include "store/table.h"
#include "study/error_models.h"

namespace surveymc::study {

/// One row a leg and rule that is not kept, or note.
store::Table validity_table(const survey::Survey& survey, const ToolRuns& tools,
                            const std::vector<propagate::Validity>& validity);
/// The same but for notes, as sentences that `run` prints last.
store::Table validity_warnings_table(const survey::Survey& survey, const ToolRuns& tools,
                                     const std::vector<propagate::Validity>& validity);

}  // namespace surveymc::study
