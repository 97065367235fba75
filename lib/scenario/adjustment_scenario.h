#pragma once
/// Keys that all studies of reliability share (docs/keys.md).
#include "config/config.h"
#include "reliability/observations.h"
#include "reliability/significance.h"

namespace surveymc::scenario {

/// `mode`; `[field] total_nT (51000), gravity_mps2 (9.82), declination_deg (0)` without the dip, or the field of a
/// place (reference_field.h) with it; `[sigma] ...` with the defaults of Table 1, or `sigma.reference = "wmm2025"` for
/// the error of that model in total field and dip; `stations` (30) and `systematic_terms` (false), which only
/// mse_shared uses. Sigmas that the mode does not use may be given all the same, so that the mode can be swept.
reliability::AdjustmentModel read_adjustment_model(config::ConfigReader& config);

/// `field.dip_deg` (75), or the dip of the place that `model` was read with, rad.
double read_dip(config::ConfigReader& config, const reliability::AdjustmentModel& model);

/// `alpha` (1e-4), `tails` ("one"), `power` (0.8).
reliability::TestLevels read_test_levels(config::ConfigReader& config);

}  // namespace surveymc::scenario
