#pragma once
/// The field of the tests of multi-station analysis.
#include "base/units.h"

namespace surveymc::test {
constexpr double kGravity = 9.81, kTotal = 50000, kDip = 72 * kDegree;  // m/s2, nT, rad
}
