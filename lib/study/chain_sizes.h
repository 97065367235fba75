#pragma once
#include "chained/model.h"
#include "config/config.h"
#include "survey/reference_field.h"

namespace surveymc::study {

/// `[model]` of the chained multistation solution: standard deviations of what the stations share. Defaults are those
/// of slide 7.
chained::ChainSizes read_chain_sizes(config::ConfigReader& config, const survey::ReferenceField& field);

}  // namespace surveymc::study
