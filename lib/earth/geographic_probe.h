#pragma once
#include <vector>

namespace surveymc::earth {

/// Reference fields, gravities and convergences (nT, m/s2, rad) of some places, for the probe of this build's numerics
/// (simd::numerics_probe()): GeographicLib rounds otherwise where its sums and products are fused, as Debian's
/// are for aarch64.
std::vector<double> geographic_probe();

}  // namespace surveymc::earth
