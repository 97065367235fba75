#pragma once
#include "chained/model.h"
#include "config/config.h"
#include "survey/reference_field.h"

namespace surveymc::scenario {

/// `[model]` of the chained multistation solution: standard deviations of what the stations share. Defaults are those
/// of slide 7. An offset of a reference is its sd where references are observed anew at every station. Chained
/// references begin with `random_` and `walk_`: their offsets are refused unless `references_anew`.
chained::ChainSizes read_chain_sizes(config::ConfigReader& config, const survey::ReferenceField& field,
                                     bool references_anew);

}  // namespace surveymc::scenario
