#pragma once
#include <vector>

#include "config/config.h"
#include "store/result_file.h"

namespace surveymc::cli {

/// The files that were stored beside the config, as the config reader wants them.
struct StoredInputs {
  std::vector<config::InputTable> tables;
  std::vector<config::InputText> texts;
  std::vector<config::InputReference> references;  ///< too large to be stored: what identifies them
};
StoredInputs stored_inputs(const store::Result& result);

}  // namespace surveymc::cli
