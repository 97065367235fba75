#pragma once
#include <cmath>

namespace surveymc::stats {

/// P(N > x) of a normal variable N with mean 0.
inline double normal_upper_tail(double x, double sd = 1) { return std::erfc(x / (sd * std::sqrt(2.0))) / 2; }

}  // namespace surveymc::stats
