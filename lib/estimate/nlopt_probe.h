#pragma once
#include <vector>

namespace surveymc::estimate {

/// Points that NLopt's solvers (estimator.solver) reach after some steps in a curved valley, for the probe of this
/// build's numerics (simd::numerics_probe()): NLopt rounds differently where the compiler fuses multiply-adds, as in
/// Debian's build for aarch64.
std::vector<double> nlopt_probe();

}  // namespace surveymc::estimate
