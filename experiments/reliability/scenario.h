#pragma once
/// Keys of `reliability_map` and `reliability_well` for errors and for the grid (docs/keys.md).
#include <array>

#include "config/config.h"
#include "reliability/error_subject.h"
#include "reliability/reliability_grid.h"

namespace surveymc::studies::reliability {

/// `observation`: one, a list, or "all". Each must be observed in that mode.
std::vector<std::size_t> read_observations(config::ConfigReader& config, AdjustmentMode mode);

/// The errors of which maps are made, by one of
///   `observation`: one error each, as above;
///   `direction = { bx = 1.0, bz = -0.5 }`: an error in several observations at once, in standard deviations;
///   `weakest_of = ["bx", "bz"]`: of all errors in these of one length in standard deviations, the least visible one.
std::vector<ErrorSubject> read_subjects(config::ConfigReader& config, AdjustmentMode mode);

/// `gross_error_mps2`, `gross_error_nT`, `gross_error_deg`: size of the error in the observations with that unit, in
/// that unit; NaN where it is not given. Each size given must be in the unit of one of the subjects. If any size is
/// given, every subject needs one, and no subject may be a combination.
std::array<double, 3> read_gross_error(config::ConfigReader& config, const std::vector<ErrorSubject>& subjects);

/// `inclination_deg, toolface_deg, magnetic_azimuth_deg`, `field.dip_deg` (75), `noise_scale` (1): numbers, lists or
/// { from, to, step }. Where field.model is given, the one dip is `dip_of_place`, rad.
ReliabilityGrid read_grid(config::ConfigReader& config, double dip_of_place);

}  // namespace surveymc::studies::reliability
