#pragma once
#include <string>

namespace surveymc::simd {

/// Eight hexadecimal digits that tell apart machines and builds on which the same program gives other last bits: C
/// libraries, and their variants for processors, with other elementary functions, and Eigen with other vectors, whose
/// sums have another order. A hash of their values at some thousand arguments. Tallies of two such machines must not
/// mix.
std::string numerics_probe();

}  // namespace surveymc::simd
