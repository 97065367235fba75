#pragma once
#include <vector>

#include "config/config.h"
#include "store/result_file.h"

namespace surveymc::cli {

/// The input files that a result stores beside its config, in the form that the config reader takes.
struct StoredInputs {
  std::vector<config::InputTable> tables;
  std::vector<config::InputText> texts;
  std::vector<config::InputReference> references;  ///< too large to be stored: what identifies them
};
StoredInputs stored_inputs(const store::Result& result);

}  // namespace surveymc::cli
