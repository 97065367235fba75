#pragma once
/// Elementary functions for any scalar type, from one source: the system's libm chooses variants by processor, and its
/// last bits differ between machines.
///
/// Polynomials and reductions are those of fdlibm (Sun Microsystems 1993, freely distributable): e_log.c, e_exp.c,
/// k_sin.c, k_cos.c, e_asin.c. Errors below 1 ulp for log, exp, sin and cos in their range; see
/// tests/simd/test_math.cpp.
#include <utility>

#include "simd/lanes.h"

namespace surveymc::simd {

inline constexpr double kLn2High = 6.93147180369123816490e-01;  // 33 bits: its product with an exponent is exact

/// Natural logarithm of a positive normal number.
template <class T>
T log(const T& x) {
  // x = 2^e m with m in [sqrt(1/2), sqrt(2)): adding the gap from sqrt(1/2) to 1 makes the exponent field carry at
  // sqrt(2)
  const Bits<T> shifted = to_bits(x) + Bits<T>(0x3ff0000000000000u - 0x3fe6a09e667f3bcdu);
  const T e = from_bits((shifted >> 52) | Bits<T>(0x4330000000000000u)) - (0x1p52 + 1023);
  const T m = from_bits((shifted & Bits<T>(0x000fffffffffffffu)) + Bits<T>(0x3fe6a09e667f3bcdu));
  const T f = m - 1.0, s = f / (m + 1.0), z = s * s, w = z * z;
  const T odd =
      z * fma(w, fma(w, fma(w, T(1.479819860511658591e-01), T(1.818357216161805012e-01)), T(2.857142874366239149e-01)),
              T(6.666666666666735130e-01));
  const T even =
      w * fma(w, fma(w, T(1.531383769920937332e-01), T(2.222219843214978396e-01)), T(3.999999999940941908e-01));
  const T half_square = T(0.5) * f * f;
  // ln (1 + f) = f - (f^2/2 - s (f^2/2 + R)); ln2 in two parts
  const T rest = half_square - fma(s, half_square + (odd + even), e * T(1.90821492927058770002e-10));
  return fma(e, T(kLn2High), f - rest);
}

/// e^x for finite x <= 709; 0 below -708, where the result would not be a normal number. Below 1 ulp (e_exp.c).
template <class T>
T exp(const T& x) {
  constexpr double kRound = 0x1.8p52;  // adding it rounds to an integer that stands in the low bits
  const T shifted = fma(x, T(1.44269504088896338700e+00), T(kRound));
  const T n = shifted - kRound;
  const T high = fma(-n, T(kLn2High), x), low = n * T(1.90821492927058770002e-10);
  const T r = high - low, z = r * r;
  const T p = z * fma(z,
                      fma(z,
                          fma(z, fma(z, T(4.13813679705723846039e-08), T(-1.65339022054652515390e-06)),
                              T(6.61375632143793436117e-05)),
                          T(-2.77777777770155933842e-03)),
                      T(1.66666666666666019037e-01));
  const T c = r - p;
  const T y = T(1.0) - ((low - (r * c) / (T(2.0) - c)) - high);
  return select(x < T(-708.0), T(0.0), from_bits(to_bits(y) + (to_bits(shifted) << 52)));
}

/// {sin x, cos x} for |x| <= pi/4.
template <class T>
[[gnu::always_inline]] inline std::pair<T, T> sincos_reduced(const T& x) {
  const T z = x * x;
  const T s = fma(z,
                  fma(z,
                      fma(z,
                          fma(z, fma(z, T(1.58969099521155010221e-10), T(-2.50507602534068634195e-08)),
                              T(2.75573137070700676789e-06)),
                          T(-1.98412698298579493134e-04)),
                      T(8.33333333332248946124e-03)),
                  T(-1.66666666666666324348e-01));
  const T c = fma(z,
                  fma(z,
                      fma(z,
                          fma(z, fma(z, T(-1.13596475577881948265e-11), T(2.08757232129817482790e-09)),
                              T(-2.75573143513906633035e-07)),
                          T(2.48015872894767294178e-05)),
                      T(-1.38888888888741095749e-03)),
                  T(4.16666666666666019037e-02));
  return {fma(x * z, s, x), fma(z * z, c, fma(z, T(-0.5), T(1.0)))};
}

/// Turns {sin, cos} of a reduced angle by q quarter turns, q = 0, 1, 2, 3 (higher bits of q are ignored).
template <class T>
std::pair<T, T> turn_by_quarters(const std::pair<T, T>& sc, const Bits<T>& q) {
  const Bits<T> sign_s = (q & Bits<T>(2)) << 62, sign_c = ((q + Bits<T>(1)) & Bits<T>(2)) << 62;
  const T s = select(odd(q), sc.second, sc.first), c = select(odd(q), sc.first, sc.second);
  return {from_bits(to_bits(s) ^ sign_s), from_bits(to_bits(c) ^ sign_c)};
}

/// {sin x, cos x} for |x| < 1e5 rad; absolute error below 3e-16.
template <class T>
std::pair<T, T> sincos(const T& x) {
  constexpr double kRound = 0x1.8p52;  // adding it rounds to an integer that stands in the low bits
  const T shifted = fma(x, T(6.36619772367581382433e-01), T(kRound));
  const T n = shifted - kRound;
  // pi/2 in three parts; the first two have 33 bits, so their products with n are exact for |n| < 2^20.
  T r = fma(-n, T(1.57079632673412561417e+00), x);
  r = fma(-n, T(6.07710050630396597660e-11), r);
  r = fma(-n, T(2.02226624879595063154e-21), r);
  return turn_by_quarters(sincos_reduced(r), to_bits(shifted));
}

/// asin(x) / x as a function of z = x^2, for z <= 0.25. Even and smooth: no square root is needed.
template <class T>
T asin_ratio(const T& z) {
  const T p = z * fma(z,
                      fma(z,
                          fma(z,
                              fma(z, fma(z, T(3.47933107596021167570e-05), T(7.91534994289814532176e-04)),
                                  T(-4.00555345006794114027e-02)),
                              T(2.01212532134862925881e-01)),
                          T(-3.25565818622400915405e-01)),
                      T(1.66666666666666657415e-01));
  const T q = fma(
      z,
      fma(z,
          fma(z, fma(z, T(7.70381505559019352791e-02), T(-6.88283971605453293030e-01)), T(2.02094576023350569471e+00)),
          T(-2.40339491173441421878e+00)),
      T(1.0));
  return p / q + 1.0;
}

}  // namespace surveymc::simd
