#pragma once
#include <string>

#include "config/config.h"
#include "single_station/station_solution.h"

namespace surveymc::scenario {

/// `[sigma] accelerometer_xy_mps2 (0), accelerometer_z_mps2 (as xy), gravity_mps2 (0), magnetometer_xy_nT,
/// magnetometer_z_nT (as xy), horizontal_nT (0), vertical_nT, axial_magnetisation_nT (0)`. One sd each.
single_station::StationSigmas read_station_sigmas(config::ConfigReader& config);

/// Throws InputError, naming `key` or the sigma, unless `method` can weigh with these sigmas.
void require_station_sigmas(const config::ConfigReader& config, const std::string& key,
                            single_station::StationMethod method, const single_station::StationSigmas& sigmas);

}  // namespace surveymc::scenario
