#pragma once
/// surveymc refine RESULT.h5 -o next.toml: the next round of a sweep; and rounds put together to one result.
#include <string>
#include <vector>

#include "study/experiment.h"

namespace surveymc::cli {

struct RefineArguments {
  std::string file, output;
  bool overwrite = false;
};

/// Writes the config and, beside it, its table of points; says so and writes nothing if the boundary is as fine as the
/// config wants it. Throws InputError, IoError.
int refine_result(const std::vector<study::Experiment>& studies, const RefineArguments& arguments);

/// One result of several, which are rounds of one sweep. `output`: its name; `folder`: of the config.
store::Result merge_rounds(const std::vector<study::Experiment>& studies, const std::vector<std::string>& files,
                           const std::string& output, const std::string& folder);

}  // namespace surveymc::cli
