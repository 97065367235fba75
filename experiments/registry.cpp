#include "experiments.h"

namespace surveymc {

std::vector<Experiment> all_experiments() { return {msa_position_experiment()}; }

}  // namespace surveymc
