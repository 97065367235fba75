#pragma once
/// `surveymc new`: a commented config of an experiment, to be filled in.
#include <string>
#include <vector>

#include "study/experiment.h"

namespace surveymc::cli {

struct NewArguments {
  std::string experiment, output;  ///< output: empty for stdout
};

/// Prints the config, or writes it to a.output, and beside it the example data that it names and that are not there.
/// Never writes over a file. Throws UsageError for an unknown experiment, IoError.
void new_config(const std::vector<study::Experiment>& studies, const NewArguments& a);

}  // namespace surveymc::cli
