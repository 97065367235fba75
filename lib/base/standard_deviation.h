#pragma once
#include <cmath>

namespace surveymc {

/// Square root of a variance. A negative variance is a rounded zero. NaN stays NaN, which sqrt(max(0, NaN)) = 0 would
/// hide.
inline double standard_deviation(double variance) { return variance <= 0 ? 0.0 : std::sqrt(variance); }

}  // namespace surveymc
