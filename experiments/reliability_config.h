#pragma once
/// Keys that the reliability studies share (docs/results-format.md).
#include <array>

#include "config/config.h"
#include "error_subject.h"
#include "reliability/reliability_grid.h"
#include "reliability/significance.h"

namespace surveymc {

/// `mode`; `[field] total_nT (51000), gravity_mps2 (9.82), declination_deg (0)` without the dip; `[sigma] ...` with the
/// defaults of Table 1; `stations` (30) and `systematic_terms` (false), which only mse_shared uses. Sigmas that the
/// mode does not use may be given all the same, so that the mode can be swept.
AdjustmentModel read_adjustment_model(ConfigReader& config);

/// `alpha` (1e-4), `tails` ("one"), `power` (0.8).
TestLevels read_test_levels(ConfigReader& config);

/// `observation`: one, a list, or "all". Each must be observed in that mode.
std::vector<std::size_t> read_observations(ConfigReader& config, AdjustmentMode mode);

/// What the maps are about, one of
///   `observation`: one error each, as above;
///   `direction = { bx = 1.0, bz = -0.5 }`: an error in several observations at once, in standard deviations;
///   `weakest_of = ["bx", "bz"]`: the error in these, of all of one length in standard deviations, that shows least.
std::vector<ErrorSubject> read_subjects(ConfigReader& config, AdjustmentMode mode);

/// `gross_error_mps2`, `gross_error_nT`, `gross_error_deg`: size of the error in the observations with that unit, in
/// that unit; NaN where it is not given. Each must be the unit of one of the subjects, and each of them, of which none
/// may be a combination, have its own if there is one at all.
std::array<double, 3> read_gross_error(ConfigReader& config, const std::vector<ErrorSubject>& subjects);

/// `inclination_deg, toolface_deg, magnetic_azimuth_deg`, `field.dip_deg` (75), `noise_scale` (1): numbers, lists or
/// { from, to, step }.
ReliabilityGrid read_grid(ConfigReader& config);

}  // namespace surveymc
