#pragma once
#include "config/input_table.h"
#include "survey/survey.h"

namespace surveymc::config {

/// From which axis a survey file measures toolface: "x" (thesis) or "y" (ISCWSA).
enum class ToolfaceZero { x, y };
/// From which north a survey file measures azimuth.
enum class AzimuthReference { true_north, magnetic, grid };

struct SurveyConventions {
  ToolfaceZero toolface_zero = ToolfaceZero::y;
  AzimuthReference azimuth_reference = AzimuthReference::true_north;
  double declination = 0;  ///< rad; magnetic + declination = true
  double convergence = 0;  ///< rad; grid + convergence = true
};

/// The north that a table names: by its column `azimuth_true_deg`, `azimuth_magnetic_deg` or `azimuth_grid_deg`.
/// `azimuth_unreferenced_deg` says that it has to be asked for, `azimuth_deg` leaves it to the config.
enum class NamedNorth { none, unreferenced, true_north, magnetic, grid };
NamedNorth named_north(const InputTable& table);
/// Index of the azimuth column, whatever north it names, or -1.
int azimuth_column(const InputTable& table);

/// Throws InputError for the first column whose name no survey has, with the names that it may have.
void require_survey_names(const InputTable& table);

/// Survey from a file with columns `md_m` or `md_ft`, `inclination_deg`, `azimuth_deg` (or with a north in its name,
/// as above) and, if present, `toolface_deg` (zero without), `tvd_m` or `tvd_ft`, and `time_s`. Throws InputError
/// "path:line: column = value: rule" on a missing or unknown column or unit, a measured depth that does not increase,
/// or an inclination outside [0, 180]. `needs_toolface`: its absence is an error.
survey::Survey survey_from_table(const InputTable& table, const SurveyConventions& conventions, bool needs_toolface);

/// True vertical depth of every station in metres, from a column `tvd_m` or `tvd_ft`; empty if the file has none.
std::vector<double> tvd_from_table(const InputTable& table);

/// Time of every station in s, from a column `time_s`; empty if the file has none. Throws InputError where it falls.
std::vector<double> times_from_table(const InputTable& table);

}  // namespace surveymc::config
