#pragma once
/// What the configs of `reliability_map` and `reliability_well` say of errors and of the grid (docs/results-format.md).
#include <array>

#include "config/config.h"
#include "reliability/error_subject.h"
#include "reliability/reliability_grid.h"

namespace surveymc::studies::reliability {

/// `observation`: one, a list, or "all". Each must be observed in that mode.
std::vector<std::size_t> read_observations(config::ConfigReader& config, surveymc::reliability::AdjustmentMode mode);

/// What the maps are about, one of
///   `observation`: one error each, as above;
///   `direction = { bx = 1.0, bz = -0.5 }`: an error in several observations at once, in standard deviations;
///   `weakest_of = ["bx", "bz"]`: the error in these, of all of one length in standard deviations, that shows least.
std::vector<ErrorSubject> read_subjects(config::ConfigReader& config, surveymc::reliability::AdjustmentMode mode);

/// `gross_error_mps2`, `gross_error_nT`, `gross_error_deg`: size of the error in the observations with that unit, in
/// that unit; NaN where it is not given. Each must be the unit of one of the subjects, and each of them, of which none
/// may be a combination, have its own if there is one at all.
std::array<double, 3> read_gross_error(config::ConfigReader& config, const std::vector<ErrorSubject>& subjects);

/// `inclination_deg, toolface_deg, magnetic_azimuth_deg`, `field.dip_deg` (75), `noise_scale` (1): numbers, lists or
/// { from, to, step }.
surveymc::reliability::ReliabilityGrid read_grid(config::ConfigReader& config);

}  // namespace surveymc::studies::reliability
