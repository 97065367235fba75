#pragma once
/// Tables and maps of a point as bytes: what a part file holds of a study without trials.
#include <string>
#include <string_view>

#include "study/experiment.h"

namespace surveymc::study {

/// Streams are run through; they come back as streams of values that are held. Throws IoError if these are more than
/// kMostPartValues.
inline constexpr std::size_t kMostPartValues = std::size_t{1} << 28;
std::string point_result_to_bytes(const PointResult& result);

/// Throws IoError if the bytes are damaged.
PointResult point_result_from_bytes(std::string_view bytes);

}  // namespace surveymc::study
