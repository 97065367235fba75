#pragma once
/// Points of a large sweep that cannot be run, and why.
#include <string>

#include "study/experiment.h"

namespace surveymc::study {

/// Name of the table that lists them.
inline constexpr const char* kFailedPoints = "failed_points";

/// The message of an InputError without the "file:line: " where it begins so: a result does not depend on the name of
/// the config.
std::string without_place(const std::string& message);

/// The result of a point that cannot be run: a row of the table failed_points.
PointResult failed_point(std::size_t point, const std::string& reason);

/// True of failed_point().
bool is_failed(const PointResult& result);

}  // namespace surveymc::study
