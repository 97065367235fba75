#pragma once
/// Hashes of what a result holds; input_hash() and content_hash() are in result_file.h.
#include <string>

#include "store/table.h"

namespace surveymc {

/// Equal for axes that two maps can share: the same name, unit, long name and values.
std::string axis_hash(const Axis& axis);

}  // namespace surveymc
