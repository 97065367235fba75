#pragma once
/// `surveymc keys`: every key of an experiment's configs.
#include <string>
#include <vector>

#include "study/experiment.h"

namespace surveymc::cli {

struct KeysArguments {
  std::string experiment;  ///< empty: the list of experiments
  bool csv = false;
};

/// The experiment of this name. Throws UsageError with the nearest name. `command`: for the message.
const study::Experiment& experiment_named(const std::vector<study::Experiment>& studies, const std::string& name,
                                          const std::string& command);

std::string list_text(const std::vector<study::Experiment>& studies);

std::string keys_text(const std::vector<study::Experiment>& studies, const KeysArguments& a);

}  // namespace surveymc::cli
