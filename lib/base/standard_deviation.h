#pragma once
#include <cmath>

namespace surveymc {

/// The root of a variance. One below zero is a rounded zero; one that is not there (NaN) stays so, which
/// sqrt(max(0, NaN)) = 0 would hide.
inline double standard_deviation(double variance) { return variance <= 0 ? 0.0 : std::sqrt(variance); }

}  // namespace surveymc
