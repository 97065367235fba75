#pragma once
/// The files that a config names, as a result stores them.
#include <vector>

#include "config/config.h"
#include "store/result_file.h"

namespace surveymc::study {

/// Tables, texts and references to large files that were read for the points of the config.
std::vector<store::InputData> input_tables(const config::Config& config);

}  // namespace surveymc::study
