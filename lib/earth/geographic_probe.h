#pragma once
#include <vector>

namespace surveymc::earth {

/// Reference fields, gravities and convergences (nT, m/s2, rad) of some places, for the probe of this build's numerics
/// (simd::numerics_probe()): GeographicLib rounds differently where the compiler fuses multiply-adds, as in Debian's
/// build for aarch64.
std::vector<double> geographic_probe();

}  // namespace surveymc::earth
