#pragma once
/// Measured depths that are the same to a user, and where on a survey they are.
#include <cmath>
#include <cstddef>
#include <optional>

#include "survey/survey.h"

namespace surveymc::survey {

/// The rule (kSameDepth) for stations, kick-offs, ends of intervals, tie-ons and depths that a config lists, m.
inline bool is_same_depth(double a, double b) { return std::abs(a - b) < kSameDepth; }
inline bool is_deeper(double md, double than) { return md - than >= kSameDepth; }

/// The station at a measured depth (m), the nearest if there are several; nothing if there is none.
std::optional<std::size_t> station_at(const Survey& survey, double md);
/// A measured depth (m) that somebody wrote, as the survey has it: that of the station there, or the depth itself
/// between stations; nothing beyond the ends of the survey.
std::optional<double> depth_on(const Survey& survey, double md);

}  // namespace surveymc::survey
