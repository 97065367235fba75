#pragma once
#include "config/input_table.h"
#include "survey/six_axis.h"

namespace surveymc::config {

/// What a file's accelerometers point along: gravity (down, a tool standing up reads +z), or the specific force that
/// holds the tool against it (up). Both are in use.
enum class AccelerometerSign { gravity, specific_force };

/// Fewest stations that six unknowns can come from: two residuals each.
inline constexpr std::size_t kFewestStations = 3;

struct ReadingsConventions {
  AccelerometerSign accelerometers = AccelerometerSign::gravity;
  double gravity = 9.80665;  ///< m/s2, of the reference
  double total_field = 0;    ///< nT, of the reference
  /// 1 for what solves every station with unknowns of its own, or has priors for all.
  std::size_t fewest_stations = kFewestStations;
  /// The tool is not calibrated: biases of its magnetometers may be as large as the field.
  bool is_uncalibrated = false;
};

/// Throws InputError for the first column whose name no file of readings has, with the names that it may have.
void require_readings_names(const InputTable& table);

/// Six-axis readings from a file with the columns `md_m` or `md_ft`; `gx, gy, gz` in `_mps2` or `_mg`; `bx, by, bz` in
/// `_nT` or `_uT`, in any order, one unit for the three of a kind. Throws InputError "path:line: column = value: rule"
/// on a missing or unknown column or unit, a measured depth that does not increase, fewer than fewest_stations
/// stations, and readings that no tool reports whatever its errors: gravity beyond half to twice the reference, or a
/// total field beyond a third to three times it, a tenth to ten times of a tool that is not calibrated (columns
/// swapped, or another unit than the header says).
survey::SixAxisReadings readings_from_table(const InputTable& table, const ReadingsConventions& conventions);

}  // namespace surveymc::config
