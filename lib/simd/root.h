#pragma once
/// Square roots without the divider of the processor, which takes one root or quotient at a time. Where a kernel has
/// many of both, half of its roots by products let it compute the others meanwhile.
#include "simd/lanes.h"

namespace surveymc::simd {
inline namespace SURVEYMC_ISA {

/// True where there is a first guess for all lanes in one instruction.
template <class T>
inline constexpr bool kRootsByProducts = false;
template <>
inline constexpr bool kRootsByProducts<Lanes> = SURVEYMC_LANES == 8;
inline constexpr double kLeastRoot = 0x1p-900, kLargestRoot = 0x1p1000;

/// sqrt(x), the same bits, for x in [kLeastRoot, kLargestRoot].
inline double sqrt_by_products(double x) { return sqrt(x); }
#if SURVEYMC_LANES == 8
/// Two steps of Newton for g = sqrt(x) and h = 1 / (2 sqrt(x)), from a guess accurate to 2^-14, leave errors of g
/// and h below 2.5 2^-53 of them. g + (x - g g) h is then wrong by less than 12 2^-53 of its last place before it is
/// rounded. So it is rounded as sqrt() is, unless sqrt(x) is nearer than that to the middle of two numbers, (M + 1/2)
/// last places: then x, in their squares, is (M + 1/2)^2 + j / 4 with |j| < 100. There are few such x in [1, 4), and
/// tests/simd/lane_bits.cpp tries all of them.
inline Lanes sqrt_by_products(Lanes x) {
  const Lanes guess = Lanes::Vector(_mm512_maskz_rsqrt14_pd(0xff, x.v)), half = 0.5;
  Lanes g = x * guess, h = half * guess;
  for (int step = 0; step < 2; ++step) {
    const Lanes r = fma(-g, h, half);
    g = fma(g, r, g);
    h = fma(h, r, h);
  }
  return fma(fma(-g, g, x), h, g);
}
#else
inline Lanes sqrt_by_products(Lanes x) { return sqrt(x); }
#endif

}  // namespace SURVEYMC_ISA
}  // namespace surveymc::simd
