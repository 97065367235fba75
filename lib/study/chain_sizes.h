#pragma once
#include "config/config.h"
#include "estimate/chained_model.h"
#include "field/reference_field.h"

namespace surveymc {

/// `[model]` of the chained multistation solution: standard deviations of what the stations share. Defaults are those
/// of slide 7.
ChainSizes read_chain_sizes(ConfigReader& config, const ReferenceField& field);

}  // namespace surveymc
