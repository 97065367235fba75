#pragma once
/// Draws of the stream that a trial gets, and their sign.
#include "simd/math.h"

namespace surveymc::random {

using namespace simd;

template <class T>
struct DrawAddress {
  Bits<T> trial, sign;
};

/// Antithetic trials 2j and 2j + 1 have the draws of the stream's trial j, the second with the opposite sign.
template <class T>
DrawAddress<T> draw_address(const Bits<T>& trial, bool antithetic) {
  if (!antithetic) return {trial, Bits<T>(0)};
  return {trial >> 1, trial << 63};
}

template <class T>
T signed_draw(const T& draw, const DrawAddress<T>& from) {
  return from_bits(to_bits(draw) ^ from.sign);
}

}  // namespace surveymc::random
