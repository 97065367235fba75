#pragma once
/// Minutes of a geomagnetic observatory.
#include "config/input_file.h"
#include "disturbance/process.h"

namespace surveymc::config {

/// The series of a file in IAGA-2002 (reported elements XYZ, HEZ or HDZ; D in minutes of arc, east), or in CSV with the
/// columns `time` (ISO 8601), `x_nT`, `y_nT` and `z_nT` (north, east, down). X and Y are turned to the mean horizontal
/// field of the file; H and E are taken as they are. All steps must be equal, and no value may be missing: throws
/// InputError "path:line: ..." at the first gap, with its time. Values are not yet less any level.
disturbance::Series observatory_series(const InputFile& file);

}  // namespace surveymc::config
