#pragma once
/// All studies. A new study adds a line to registry.cpp.
#include <vector>

#include "study/experiment.h"

namespace surveymc::studies {

/// All studies, in the order of `surveymc list`.
std::vector<study::Experiment> all_experiments();

}  // namespace surveymc::studies
