#pragma once
#include "analysis/well_design.h"
#include "config/config.h"

namespace surveymc::scenario {

/// `[well] kind, stations, spacing_m (30), build_rate_deg_per_30m (3), toolface ("even")`.
analysis::WellDesign read_well_design(config::ConfigReader& config, random::StudySeed seed);

}  // namespace surveymc::scenario
