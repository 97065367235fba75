#pragma once
#include <string>

namespace surveymc::simd {

/// Eight hexadecimal digits that tell apart C libraries, and their variants for processors, whose elementary functions
/// differ in last bits: a hash of the values of 23 functions at 128 arguments. Tallies of two such machines must not
/// mix.
std::string libm_fingerprint();

}  // namespace surveymc::simd
