#pragma once
/// Why a point of a large sweep cannot be run.
#include <string>

namespace surveymc::study {

/// The message of an InputError without the "file:line: " where it begins so: a result does not depend on the name of
/// the config.
std::string without_place(const std::string& message);

}  // namespace surveymc::study
