#pragma once
#include <string>

#include "config/config.h"
#include "estimate/single_station.h"

namespace surveymc {

/// `[sigma] accelerometer_xy_mps2 (0), accelerometer_z_mps2 (as xy), gravity_mps2 (0), magnetometer_xy_nT,
/// magnetometer_z_nT (as xy), horizontal_nT (0), vertical_nT, axial_magnetisation_nT (0)`. One sd each.
StationSigmas read_station_sigmas(ConfigReader& config);

/// Throws InputError, naming `key` or the sigma, unless `method` can weigh with these sigmas.
void require_station_sigmas(const ConfigReader& config, const std::string& key, StationMethod method,
                            const StationSigmas& sigmas);

}  // namespace surveymc
