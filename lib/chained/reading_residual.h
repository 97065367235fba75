#pragma once
/// What the readings of a station say against the model of make_model.h: the one readable formula. The solvers have
/// its Jacobian by hand; tests hold that against Dual numbers of this.
#include <array>

#include "chained/model.h"
#include "survey/frames.h"

namespace surveymc::chained {

/// North and down in the tool frame, orthonormal; east is d x n.
template <class T>
struct ToolFrame {
  survey::Vec3<T> n, d;
};

/// v turned by the rotation vector `delta` (rad) to second order in it, exactly orthogonal (Cayley): with s = delta / 2
///   v' = v + 2 / (1 + s.s) (s x v + s x (s x v)).
/// No trigonometry, and the same derivative at 0 as exp([delta]x): minima and covariances are the same.
template <class T>
survey::Vec3<T> turned(const survey::Vec3<T>& delta, const survey::Vec3<T>& v) {
  const survey::Vec3<T> s = scale(T(0.5), delta), a = cross(s, v);
  return v + scale(T(2.0) / (T(1.0) + dot(s, s)), a + cross(s, a));
}

/// Removes what rounding does to orthonormality.
template <class T>
ToolFrame<T> orthonormal(const ToolFrame<T>& m) {
  const survey::Vec3<T> d = scale(T(1.0) / norm(m.d), m.d), n = m.n - scale(dot(m.n, d), d);
  return {scale(T(1.0) / norm(n), n), d};
}

template <class T>
ToolFrame<T> turned(const survey::Vec3<T>& delta, const ToolFrame<T>& m) {
  return orthonormal(ToolFrame<T>{turned(delta, m.n), turned(delta, m.d)});
}

/// e = y - (f, h):
///   f = -(g + c0) d + c3..5,   h = (Bh + c1) n + (Bd + c2) d + c6..8 + [n e d] i
/// y, e: m/s2 and nT. `interference` is i in N-E-V at this station, nT. T: double, Lanes, or Dual of either.
template <class T>
std::array<T, 6> reading_residual(double gravity, double horizontal, double down, const std::array<T, 6>& y,
                                  const ToolFrame<T>& m, const std::array<T, kChainStates>& c,
                                  const survey::Vec3<T>& interference) {
  const T g = T(gravity) + c[0], bh = T(horizontal) + c[1] + interference.x, bd = T(down) + c[2] + interference.z;
  const survey::Vec3<T> e = cross(m.d, m.n), f = scale(-g, m.d),
                        h = scale(bh, m.n) + scale(interference.y, e) + scale(bd, m.d);
  return {y[0] - (f.x + c[3]), y[1] - (f.y + c[4]), y[2] - (f.z + c[5]),
          y[3] - (h.x + c[6]), y[4] - (h.y + c[7]), y[5] - (h.z + c[8])};
}

}  // namespace surveymc::chained
