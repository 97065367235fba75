#pragma once
/// Surveys whose stations are far apart: what their spacing does to the covariance, and stations between them.
#include <string>
#include <vector>

#include "compare/warnings.h"
#include "config/config.h"
#include "scenario/error_models.h"
#include "survey/reference_field.h"

namespace surveymc::scenario {

inline constexpr const char* kInterpolate = "survey.interpolate_m";

/// A survey by key points is no survey: error models have sources that are drawn anew at every station (course length:
/// XCLA, XCLH), whose variance grows with the third power of the spacing. Rule: if stations are more than 100 m apart,
/// the covariance is computed also with stations every 30 m on the same path; a warning is added where that makes the
/// position's standard deviation (root of the trace) at the last station smaller by a factor of more than 1.2.
/// `tvd`: of every station, m. `well`: its name, where there are several. `key`: the way out.
void add_spacing_warning(std::vector<compare::Warning>& warnings, const survey::Survey& survey,
                         const std::vector<double>& tvd, const ToolRuns& tools, const survey::ReferenceField& field,
                         double latitude, const std::string& well = "", const std::string& key = kInterpolate);

/// The survey with the stations that `key` ("survey.interpolate_m") asks for between its own; without the key as it is.
survey::Survey read_interpolation(config::ConfigReader& config, const std::string& key, const survey::Survey& survey,
                                  bool needs_toolface);

/// True vertical depth of every station, m: as `table` lists it, from which `survey` was made, and between the stations
/// of the table in proportion; by minimum curvature where the table has none.
std::vector<double> true_vertical_depths_of(const config::InputTable& table, const survey::Survey& survey);

}  // namespace surveymc::scenario
