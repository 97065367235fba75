#pragma once
/// Every study, by name. A new one adds its line to registry.cpp.
#include <vector>

#include "study/experiment.h"

namespace surveymc::studies {

/// All of them, in the order of `surveymc list`.
std::vector<study::Experiment> all_experiments();

}  // namespace surveymc::studies
