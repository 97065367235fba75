#pragma once
#include <vector>

#include "config/config.h"
#include "store/result_file.h"

namespace surveymc {

/// The files that were stored beside the config, as the config reader wants them.
struct StoredInputs {
  std::vector<InputTable> tables;
  std::vector<InputText> texts;
  std::vector<InputReference> references;  ///< too large to be stored: what identifies them
};
StoredInputs stored_inputs(const Result& result);

}  // namespace surveymc
