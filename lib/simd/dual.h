#pragma once
/// Forward-mode derivative numbers: the oracle of every hand-written Jacobian. Not for hot loops.
#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "simd/lanes.h"
#include "simd/math.h"

namespace surveymc::simd {

/// a + sum_i d[i] e_i with e_i e_j = 0. T may itself be Lanes.
template <class T, std::size_t N>
struct Dual {
  T a{};
  std::array<T, N> d{};

  Dual() = default;
  Dual(const T& value) : a(value) {}  // NOLINT: constants mix freely
  Dual(double value)                  // NOLINT
      requires(!std::is_same_v<T, double>)
      : a(value) {}
  static Dual variable(const T& value, std::size_t index) {
    Dual x(value);
    x.d[index] = T(1.0);
    return x;
  }

  friend Dual operator+(Dual x, const Dual& y) {
    x.a = x.a + y.a;
    for (std::size_t i = 0; i < N; ++i) x.d[i] = x.d[i] + y.d[i];
    return x;
  }
  friend Dual operator-(Dual x, const Dual& y) {
    x.a = x.a - y.a;
    for (std::size_t i = 0; i < N; ++i) x.d[i] = x.d[i] - y.d[i];
    return x;
  }
  friend Dual operator-(Dual x) { return Dual(T(0.0)) - x; }
  friend Dual operator*(const Dual& x, const Dual& y) {
    Dual r(x.a * y.a);
    for (std::size_t i = 0; i < N; ++i) r.d[i] = x.d[i] * y.a + x.a * y.d[i];
    return r;
  }
  friend Dual operator/(const Dual& x, const Dual& y) {
    const T q = x.a / y.a;
    Dual r(q);
    for (std::size_t i = 0; i < N; ++i) r.d[i] = (x.d[i] - q * y.d[i]) / y.a;
    return r;
  }
  friend auto operator<(const Dual& x, const Dual& y) { return x.a < y.a; }
  friend auto operator>(const Dual& x, const Dual& y) { return x.a > y.a; }
  friend Dual fma(const Dual& x, const Dual& y, const Dual& z) { return x * y + z; }
  friend Dual sqrt(const Dual& x) {
    using simd::sqrt;
    const T s = sqrt(x.a);
    Dual r(s);
    for (std::size_t i = 0; i < N; ++i) r.d[i] = x.d[i] / (T(2.0) * s);
    return r;
  }
  friend std::pair<Dual, Dual> sincos(const Dual& x) {
    using simd::sincos;
    const auto [s, c] = sincos(x.a);
    Dual sine(s), cosine(c);
    for (std::size_t i = 0; i < N; ++i) {
      sine.d[i] = c * x.d[i];
      cosine.d[i] = -(s * x.d[i]);
    }
    return {sine, cosine};
  }
  template <class Mask>
  friend Dual select(const Mask& c, const Dual& x, const Dual& y) {
    using simd::select;
    Dual r(select(c, x.a, y.a));
    for (std::size_t i = 0; i < N; ++i) r.d[i] = select(c, x.d[i], y.d[i]);
    return r;
  }
};

}  // namespace surveymc::simd
