#pragma once
/// The files that a config names, as a result stores them.
#include <vector>

#include "config/config.h"
#include "store/result_file.h"

namespace surveymc::study {

/// Of the stored table of a user's file that has more lines than rows and a header: where the rows stood.
inline constexpr const char* kLineColumn = "file_line";

/// Tables, texts and references to large files that were read for the points of the config.
std::vector<store::InputData> input_tables(const config::Config& config);

}  // namespace surveymc::study
