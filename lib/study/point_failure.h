#pragma once
/// Why a point of a large sweep cannot be run.
#include <string>

namespace surveymc::study {

/// Name of the table that lists them.
inline constexpr const char* kFailedPoints = "failed_points";

/// The message of an InputError without the "file:line: " where it begins so: a result does not depend on the name of
/// the config.
std::string without_place(const std::string& message);

}  // namespace surveymc::study
