#pragma once
/// Stations between those of a survey, on the path that minimum curvature gives it.
#include <cstddef>
#include <vector>

#include "survey/survey.h"

namespace surveymc::survey {

struct InterpolatedSurvey {
  Survey survey;
  std::vector<std::size_t> given;  ///< index of each station of the given survey
};

/// The survey with more stations: every interval that is longer than `spacing` (m) is divided evenly, into parts of at
/// most `spacing`. Given stations stay, bit by bit. A station at the share f of an interval between the unit tangents
/// t1 and t2, which enclose the dogleg b, has the direction of the arc there:
///   t = (sin((1 - f) b) t1 + sin(f b) t2) / sin b
/// Azimuth: where the hole is vertical that of the interval's end. Toolface: that of the interval's end, which means
/// nothing there.
InterpolatedSurvey interpolated(const Survey& survey, double spacing);

/// Number of its stations; a double, because a mistaken spacing gives more than an integer holds.
double interpolated_stations(const Survey& survey, double spacing);

/// The longest distance between neighbours, m.
double longest_interval(const Survey& survey);

/// Values of the given stations (true vertical depths) at all stations: `along` of the interpolated survey is what they
/// follow between those (by minimum curvature), up to a linear part that makes them meet the given ones.
std::vector<double> interpolated_values(const InterpolatedSurvey& dense, const std::vector<double>& given,
                                        const std::vector<double>& along);

}  // namespace surveymc::survey
