#pragma once
/// A point of the plane, measured with independent errors, and its distance from the origin, observed too:
///
///   minimise (x - x0)^2 / px + (y - y0)^2 / py + (rho - radius)^2 / variance,   rho = sqrt(x^2 + y^2)
///
/// Least squares with the row (cos, sin) of rho, iterated to the end. It is not convex: without enough weight on the
/// point there is a minimum on either side of the origin. Where the derivative vanishes
///   x = x0 / (1 + l px),  y = y0 / (1 + l py),  l variance rho = rho - radius,
/// and at the lowest minimum 1 + l px >= 0 and 1 + l py >= 0 (the condition of trust regions: Conn, Gould and Toint
/// 2000, section 7.3). There rho falls with l and radius / (1 - l variance) rises: one root, found by Newton's method
/// on 1 / rho, which is concave and nearly straight.
#include "simd/lanes.h"

namespace surveymc::estimate {

using namespace simd;

template <class T>
struct CirclePoint {
  T x, y;
  T cost;   ///< the minimum
  T found;  ///< 1; 0 where there is no single lowest minimum: the point is on a line that either side is as good for
};

/// All of one unit; px, py, radius and variance positive. T: double, Lanes or Dual of double.
template <class T>
CirclePoint<T> pull_to_circle(const T& x0, const T& y0, const T& px, const T& py, const T& radius, const T& variance) {
  const auto swap = px < py;  // a: along the larger variance
  const T large = select(swap, py, px), per_large = T(1.0) / large, k = select(swap, px, py) * per_large;
  const T per_radius = T(1.0) / radius;
  const T a = select(swap, y0, x0) * per_radius, b = select(swap, x0, y0) * per_radius;
  const T a2 = a * a, b2 = b * b, c = variance * per_large;
  const T floor = T(1.0) - k;

  // Unknown v = 1 + l large > 0, so that x0 / v keeps all digits where v is small.
  T v(1.0);
  auto done = T(1.0) < T(0.0);
  for (int i = 0; i < 100 && !all(done); ++i) {
    const T q = fma(k, v, floor), per_q = T(1.0) / q, t = v * per_q;
    const T length2 = fma(b2 * t, t, a2), per_length = T(1.0) / sqrt(length2);  // rho = length / v
    const T value = fma(v, per_length, fma(v, c, -c) - T(1.0));
    const T slope = fma(fma(b2 * k, t * t * t, a2) * per_length * per_length, per_length, c);
    const T step = value / slope, next = v - step;
    const T taken = select(T(0.0) < next, next, T(0.5) * v);
    v = select(done, v, taken);
    const T change = step * step;
    done = done | (change < T(1e-26) * v * v);
  }
  const T q = fma(k, v, floor);
  const T along = a / v, across = b / q;
  const T x = radius * select(swap, across, along), y = radius * select(swap, along, across);
  const T dx = x - x0, dy = y - y0, dr = sqrt(fma(x, x, y * y)) - radius;
  return {x, y, fma(dx / px, dx, fma(dy / py, dy, dr / variance * dr)), select(done, T(1.0), T(0.0))};
}

}  // namespace surveymc::estimate
