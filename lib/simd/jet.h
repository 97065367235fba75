#pragma once
/// Second-order jets: value, gradient and second derivatives by N variables, for what needs all three of one formula.
/// A product takes some 7 N^2 operations, half of those of Dual<Dual<double, N>, N>, in loops that the compiler turns
/// into vectors.
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace surveymc::simd {

template <std::size_t N>
struct Jet {
  double a = 0;
  std::array<double, N> g{};
  std::array<double, N * N> h{};  ///< row by row, symmetric

  Jet() = default;
  Jet(double value) : a(value) {}  // NOLINT: constants mix freely
  static Jet variable(double value, std::size_t index) {
    Jet x(value);
    x.g[index] = 1;
    return x;
  }

  friend Jet operator+(Jet x, const Jet& y) {
    x.a += y.a;
    for (std::size_t i = 0; i < N; ++i) x.g[i] += y.g[i];
    for (std::size_t i = 0; i < N * N; ++i) x.h[i] += y.h[i];
    return x;
  }
  friend Jet operator-(Jet x, const Jet& y) {
    x.a -= y.a;
    for (std::size_t i = 0; i < N; ++i) x.g[i] -= y.g[i];
    for (std::size_t i = 0; i < N * N; ++i) x.h[i] -= y.h[i];
    return x;
  }
  friend Jet operator-(const Jet& x) { return -1.0 * x; }
  friend Jet operator*(double s, Jet x) {
    x.a *= s;
    for (double& d : x.g) d *= s;
    for (double& d : x.h) d *= s;
    return x;
  }
  friend Jet operator*(const Jet& x, const Jet& y) {
    Jet r(x.a * y.a);
    for (std::size_t i = 0; i < N; ++i) r.g[i] = x.a * y.g[i] + y.a * x.g[i];
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < N; ++j)
        r.h[i * N + j] = (x.a * y.h[i * N + j] + y.a * x.h[i * N + j]) + (x.g[i] * y.g[j] + y.g[i] * x.g[j]);
    return r;
  }
  /// f(x), by the value and the derivatives of f at x.a.
  static Jet composed(double f, double slope, double bend, const Jet& x) {
    Jet r(f);
    for (std::size_t i = 0; i < N; ++i) r.g[i] = slope * x.g[i];
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < N; ++j) r.h[i * N + j] = slope * x.h[i * N + j] + bend * (x.g[i] * x.g[j]);
    return r;
  }
  friend Jet sqrt(const Jet& x) {
    const double s = std::sqrt(x.a);
    return composed(s, 0.5 / s, -0.25 / (s * x.a), x);
  }
  friend Jet reciprocal(const Jet& x) {
    const double r = 1 / x.a;
    return composed(r, -r * r, 2 * r * r * r, x);
  }
  friend std::pair<Jet, Jet> sincos(const Jet& x) {
    const double s = std::sin(x.a), c = std::cos(x.a);
    return {composed(s, c, -s, x), composed(c, -s, -c, x)};
  }
};

}  // namespace surveymc::simd
