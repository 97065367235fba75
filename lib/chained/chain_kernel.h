#pragma once
/// Chained multistation for many trials side by side: the kernel behind smoother_lanes.h. T: double or Lanes.
///
/// Kalman filter on the nine chained states, smoothed backwards by its adjoint (Bryson and Frazier 1963: no inverse but
/// that of 3 x 3 innovation covariances), repeated as Gauss-Newton. Attitudes are eliminated by three combinations of
/// a station's linearised equations e that no rotation changes, because f x f = h x h = f x h + h x f = 0:
///   z1 = d.e_f,   z2 = h.e_h,   z3 = h.e_f + f.e_h        (h: field without offset, f = -g d)
/// with derivatives by (e_g, e_H, e_D, b_a, b_m)
///   H1 = (-1, 0, 0, d, 0),   H2 = (0, Bh, Bd, 0, h),   H3 = (-Bd, 0, -g, h, f).
#include "chained/model.h"
#include "chained/reading_residual.h"
#include "simd/solve.h"

namespace surveymc::chained {

using namespace simd;

/// The model in numbers only. No interference, no readings left out.
struct KernelModel {
  double gravity, horizontal, down, total;  ///< references; total = |(horizontal, down)|
  double noise_variance[6];
  double prior_variance[kChainStates],
      link_variance[kChainStates];  ///< of references: as they apply at a later station
  bool independent;                 ///< references forget what earlier stations said
  int stations, max_iterations;
  double step_tolerance;
};

template <class T>
using ChainCovariance = Symmetric<T, kChainStates>;

/// What filter and smoother know of a trial's station.
template <class T>
struct StationPoint {
  ToolFrame<T> frame;
  std::array<T, kChainStates> c;
};

/// First-order model of a station at a point: z, H, and what gives the attitude afterwards.
template <class T>
struct StationTerms {
  std::array<T, 6> residual;
  survey::Vec3<T> f, h;  ///< as above
  std::array<T, 3> z;
  std::array<std::array<T, kChainStates>, 3> rows;  ///< H
  Symmetric<T, 3> noise;                            ///< covariance of z
};

template <class T>
StationTerms<T> station_terms(const KernelModel& m, const std::array<T, 6>& y, const StationPoint<T>& at) {
  StationTerms<T> t;
  const T zero(0.0), g = T(m.gravity) + at.c[0], bh = T(m.horizontal) + at.c[1], bd = T(m.down) + at.c[2];
  const survey::Vec3<T>&n = at.frame.n, &d = at.frame.d;
  t.residual = reading_residual<T>(m.gravity, m.horizontal, m.down, y, at.frame, at.c, {zero, zero, zero});
  t.f = scale(-g, d);
  t.h = scale(bh, n) + scale(bd, d);
  // z2 and z3 per unit field and gravity, so that all three are of the size of the readings' errors
  const T per_b(1.0 / m.total), per_g(1.0 / m.gravity);
  const survey::Vec3<T> h = scale(per_b, t.h), f = scale(per_g, t.f), hg = scale(per_g, h), fb = scale(per_b, f);
  const auto& e = t.residual;
  const survey::Vec3<T> ef{e[0], e[1], e[2]}, eh{e[3], e[4], e[5]};
  t.z = {dot(d, ef), dot(h, eh), dot(hg, ef) + dot(fb, eh)};
  t.rows[0] = {T(-1.0), zero, zero, d.x, d.y, d.z, zero, zero, zero};
  t.rows[1] = {zero, bh * per_b, bd * per_b, zero, zero, zero, h.x, h.y, h.z};
  t.rows[2] = {zero - bd * per_b * per_g, zero, zero - g * per_b * per_g, hg.x, hg.y, hg.z, fb.x, fb.y, fb.z};
  const double* v = m.noise_variance;
  const auto weighted = [](const survey::Vec3<T>& a, const survey::Vec3<T>& b, const double* w) {
    return fma(T(w[0]) * a.x, b.x, fma(T(w[1]) * a.y, b.y, T(w[2]) * a.z * b.z));
  };
  t.noise = {weighted(d, d, v),      zero,
             weighted(h, h, v + 3),  weighted(d, hg, v),
             weighted(h, fb, v + 3), weighted(hg, hg, v) + weighted(fb, fb, v + 3)};
  return t;
}

/// One update of the filter, and what the smoother needs of it: with V = P H' S^-1 and u = S^-1 innovation.
template <class T>
struct Update {
  std::array<std::array<T, 3>, kChainStates> gain;  ///< V
  std::array<T, 3> u;
  Symmetric<T, 3> inverse;  ///< S^-1
  T minimum;                ///< innovation' S^-1 innovation: what the station adds to the cost
};

/// Updates mean and covariance in place. `at`: where the terms are linearised.
template <class T>
Update<T> update_chain(const StationTerms<T>& t, const std::array<T, kChainStates>& at,
                       std::array<T, kChainStates>& mean, ChainCovariance<T>& p) {
  Update<T> up;
  std::array<std::array<T, 3>, kChainStates> ph;
  for (std::size_t i = 0; i < kChainStates; ++i)
    for (std::size_t r = 0; r < 3; ++r) {
      T s(0.0);
      for (std::size_t j = 0; j < kChainStates; ++j) s = fma(p[j <= i ? packed(i, j) : packed(j, i)], t.rows[r][j], s);
      ph[i][r] = s;
    }
  Symmetric<T, 3> s = t.noise;
  std::array<T, 3> innovation = t.z;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t i = 0; i < kChainStates; ++i) {
      for (std::size_t l = 0; l <= r; ++l) s[packed(r, l)] = fma(t.rows[r][i], ph[i][l], s[packed(r, l)]);
      innovation[r] = fma(t.rows[r][i], at[i] - mean[i], innovation[r]);
    }
  const Symmetric<T, 3> factor = ldlt<T, 3>(s);
  up.u = ldlt_solve<T, 3>(factor, innovation);
  up.minimum = fma(up.u[0], innovation[0], fma(up.u[1], innovation[1], up.u[2] * innovation[2]));
  for (std::size_t r = 0; r < 3; ++r) {
    std::array<T, 3> unit{T(0.0), T(0.0), T(0.0)};
    unit[r] = T(1.0);
    const auto column = ldlt_solve<T, 3>(factor, unit);
    for (std::size_t l = 0; l <= r; ++l) up.inverse[packed(r, l)] = column[l];
  }
  for (std::size_t i = 0; i < kChainStates; ++i) {
    up.gain[i] = ldlt_solve<T, 3>(factor, ph[i]);
    for (std::size_t r = 0; r < 3; ++r) mean[i] = fma(ph[i][r], up.u[r], mean[i]);
    for (std::size_t j = 0; j <= i; ++j)
      for (std::size_t r = 0; r < 3; ++r) p[packed(i, j)] = fma(-up.gain[i][r], ph[j][r], p[packed(i, j)]);
  }
  return up;
}

/// Before the first station.
template <class T>
void begin_chain(const KernelModel& m, std::array<T, kChainStates>& mean, ChainCovariance<T>& p) {
  for (std::size_t i = 0; i < kChainStates; ++i) {
    mean[i] = T(0.0);
    for (std::size_t j = 0; j < i; ++j) p[packed(i, j)] = T(0.0);
    p[packed(i, i)] = T(m.prior_variance[i]);
  }
}

/// From a station to the next.
template <class T>
void predict_chain(const KernelModel& m, std::array<T, kChainStates>& mean, ChainCovariance<T>& p) {
  for (std::size_t i = 0; i < kChainStates; ++i) {
    if (m.independent)
      for (std::size_t j = 0; j <= i && j < kReferenceStates; ++j) p[packed(i, j)] = T(0.0);
    if (m.independent && i < kReferenceStates) mean[i] = T(0.0);
    p[packed(i, i)] = p[packed(i, i)] + T(m.link_variance[i]);
  }
}

/// delta = A^-1 sum w (..)x(e - by_chain dc) with A = [f]x' W [f]x + [h]x' W [h]x.
template <class T>
struct StationAttitude {
  Symmetric<T, 3> factor;  ///< ldlt(A)
  /// Right side for a change dc of the states, and residual e.
  std::array<T, 3> right_side(const KernelModel& m, const StationTerms<T>& t, const ToolFrame<T>& frame,
                              const std::array<T, 6>& e, const std::array<T, kChainStates>& dc) const {
    const double* v = m.noise_variance;
    const survey::Vec3<T> f = survey::Vec3<T>{e[0] - dc[3], e[1] - dc[4], e[2] - dc[5]} + scale(dc[0], frame.d);
    const survey::Vec3<T> h =
        survey::Vec3<T>{e[3] - dc[6], e[4] - dc[7], e[5] - dc[8]} - scale(dc[1], frame.n) - scale(dc[2], frame.d);
    const survey::Vec3<T> b = cross(t.f, {f.x * T(1 / v[0]), f.y * T(1 / v[1]), f.z * T(1 / v[2])}) +
                              cross(t.h, {h.x * T(1 / v[3]), h.y * T(1 / v[4]), h.z * T(1 / v[5])});
    return {b.x, b.y, b.z};
  }
};
template <class T>
StationAttitude<T> station_attitude(const KernelModel& m, const StationTerms<T>& t) {
  // [v]x' W [v]x has diagonal w_z v_y^2 + w_y v_z^2, ... and (0, 1) entry -w_z v_x v_y, ...
  const auto add = [](Symmetric<T, 3> a, const survey::Vec3<T>& v, const double* variance) {
    const T wx(1 / variance[0]), wy(1 / variance[1]), wz(1 / variance[2]);
    a[packed(0, 0)] = a[packed(0, 0)] + (wz * v.y * v.y + wy * v.z * v.z);
    a[packed(1, 1)] = a[packed(1, 1)] + (wz * v.x * v.x + wx * v.z * v.z);
    a[packed(2, 2)] = a[packed(2, 2)] + (wy * v.x * v.x + wx * v.y * v.y);
    a[packed(1, 0)] = a[packed(1, 0)] - wz * v.x * v.y;
    a[packed(2, 0)] = a[packed(2, 0)] - wy * v.x * v.z;
    a[packed(2, 1)] = a[packed(2, 1)] - wx * v.y * v.z;
    return a;
  };
  const T zero(0.0);
  return {ldlt<T, 3>(add(add({zero, zero, zero, zero, zero, zero}, t.f, m.noise_variance), t.h, m.noise_variance + 3))};
}

/// Backwards through a station: adjoint state and, where wanted, its covariance, from after the update to before it:
///   l <- l - H'(u + V' l),   L <- L - H' E' - E H,  E = L V - H'(S^-1 + V' L V)/2
template <class T, bool WithCovariance>
void smooth_back(const std::array<std::array<T, kChainStates>, 3>& rows, const Update<T>& up,
                 std::array<T, kChainStates>& l, ChainCovariance<T>& big) {
  std::array<T, 3> v = up.u;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t i = 0; i < kChainStates; ++i) v[r] = fma(up.gain[i][r], l[i], v[r]);
  for (std::size_t i = 0; i < kChainStates; ++i)
    for (std::size_t r = 0; r < 3; ++r) l[i] = fma(-rows[r][i], v[r], l[i]);
  if constexpr (WithCovariance) {
    std::array<std::array<T, 3>, kChainStates> lv;
    for (std::size_t i = 0; i < kChainStates; ++i)
      for (std::size_t r = 0; r < 3; ++r) {
        T s(0.0);
        for (std::size_t j = 0; j < kChainStates; ++j)
          s = fma(big[j <= i ? packed(i, j) : packed(j, i)], up.gain[j][r], s);
        lv[i][r] = s;
      }
    Symmetric<T, 3> d = up.inverse;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t q = 0; q <= r; ++q)
        for (std::size_t i = 0; i < kChainStates; ++i) d[packed(r, q)] = fma(up.gain[i][r], lv[i][q], d[packed(r, q)]);
    for (std::size_t i = 0; i < kChainStates; ++i)
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t q = 0; q < 3; ++q)
          lv[i][r] = fma(T(-0.5) * rows[q][i], d[q <= r ? packed(r, q) : packed(q, r)], lv[i][r]);
    for (std::size_t i = 0; i < kChainStates; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        T s = big[packed(i, j)];
        for (std::size_t r = 0; r < 3; ++r) s = fma(-rows[r][i], lv[j][r], fma(-lv[i][r], rows[r][j], s));
        big[packed(i, j)] = s;
      }
  }
}

}  // namespace surveymc::chained
