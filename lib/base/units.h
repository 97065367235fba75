#pragma once
/// Units inside lib/: metre, radian, m/s2, nanotesla. Degrees and feet exist only in config keys, file columns and
/// table columns, whose names end in the unit (`_deg`, `_ft`, `_nT`).
#include <limits>

namespace surveymc {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180;   ///< radians per degree
inline constexpr double kMilliG = 9.80665e-3;  ///< m/s2 in 1e-3 of standard gravity
inline constexpr double kFoot = 0.3048;        ///< metres per international foot

}  // namespace surveymc
