#pragma once
/// Nonlinear adjustment of several stations with shared references, and the tests, for any scalar type: lanes are
/// trials.
///
/// The minimum is that of adjust() (adjustment.h), with which tests compare this kernel, but by its unknowns:
/// directions u (down) and n (north) of each shot in the tool frame, and the references as z = z_0 + sd zeta. With a
/// rotational shot, all shots have the directions of the first, turned by tau_k about the axis of the tool.
///   g = G u,  b = B h,  h = cos Theta n + sin Theta u,  reading = (g, b)
///   by a small turn phi of the first shot: Rz(tau_k) phi x v;  by tau_k: z x v;  by (G, B, Theta): u, h, B m,
///   m = cos Theta u - sin Theta n
/// Gauss-Newton steps: with e the residuals and J the derivatives in units of the standard deviations,
///   J'J step = J'e;  at the minimum  Omega = |e|^2,  redundancy I - V V' with V = J L^-T, L L' = J'J,
///   w_i = e_i / sqrt(r_i),  r_i = 1 - |V_i|^2
/// Units are those of the field, as in gross_error_kernel.h.
#include <array>

#include "reliability/station_kernel.h"
#include "simd/math.h"
#include "simd/solve.h"

namespace surveymc::reliability {

inline constexpr std::size_t kShotReadings = 6;  ///< of a shot: gx, gy, gz, bx, by, bz
inline constexpr std::size_t kMostShots = 4, kMostShotUnknowns = 3 + 3 * kMostShots;
inline constexpr std::size_t kMostShotObservations = kShotReadings * kMostShots + 3;

struct ShotsModel {
  std::size_t shots;
  bool rotational;
  std::array<double, kMostShotObservations> sd;  ///< relative; readings of each shot, then references, which may be 0
  double sin_dip, cos_dip;                       ///< of the true reference dip

  std::size_t unknowns() const { return rotational ? 6 + shots - 1 : 3 + 3 * shots; }
  std::size_t observations() const { return kShotReadings * shots + 3; }
};

/// Of one adjustment. w = 0: cannot be tested (r < 1e-10).
template <class T>
struct ShotsTests {
  std::array<T, kMostShotObservations> w;
  T omega, largest;                                               ///< |w| of the largest test
  T converged;                                                    ///< 1, or 0: then the other members have no meaning
  std::array<T, kMostShotObservations * kMostShotUnknowns> base;  ///< V, row by row
};

namespace shots_kernel {

using namespace simd;

template <class T>
using V3 = std::array<T, 3>;

template <class T>
V3<T> cross3(const V3<T>& a, const V3<T>& b) {
  return {fma(a[1], b[2], -(a[2] * b[1])), fma(a[2], b[0], -(a[0] * b[2])), fma(a[0], b[1], -(a[1] * b[0]))};
}
template <class T>
T dot3(const V3<T>& a, const V3<T>& b) {
  return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2]));
}
template <class T>
V3<T> combined(const T& s, const V3<T>& a, const T& t, const V3<T>& b) {
  return {fma(s, a[0], t * b[0]), fma(s, a[1], t * b[1]), fma(s, a[2], t * b[2])};
}
template <class T>
V3<T> about_z(const T& cosine, const T& sine, const V3<T>& v) {
  return {fma(cosine, v[0], -(sine * v[1])), fma(sine, v[0], cosine * v[1]), v[2]};
}
/// v turned by Cayley's rotation of phi / 2, which agrees with phi to first order and is a rotation to rounding.
template <class T>
V3<T> turned(const V3<T>& phi, const V3<T>& v) {
  const V3<T> a{phi[0] * T(0.5), phi[1] * T(0.5), phi[2] * T(0.5)};
  const V3<T> first = cross3(a, v), second = cross3(a, first);
  const T per = T(2.0) / (T(1.0) + dot3(a, a));
  return {fma(per, first[0] + second[0], v[0]), fma(per, first[1] + second[1], v[1]),
          fma(per, first[2] + second[2], v[2])};
}

template <class T>
struct State {
  std::array<V3<T>, kMostShots> down, north;  ///< of the first alone with a rotational shot
  std::array<T, kMostShots> cosine, sine;     ///< of tau_k
  V3<T> zeta;
};

/// References at a state: G, B, and the sine and cosine of Theta.
template <class T>
struct References {
  T gravity, total, sine, cosine;
};
template <class T>
References<T> references_at(const ShotsModel& m, const V3<T>& observed, const V3<T>& zeta) {
  const std::size_t at = kShotReadings * m.shots;
  const auto [sd, cd] = sincos_reduced(fma(T(m.sd[at + 2]), zeta[2], observed[2]));
  return {fma(T(m.sd[at]), zeta[0], observed[0]), fma(T(m.sd[at + 1]), zeta[1], observed[1]),
          fma(T(m.sin_dip), cd, T(m.cos_dip) * sd), fma(T(m.cos_dip), cd, -(T(m.sin_dip) * sd))};
}

/// Residuals and derivatives of one shot in standard deviations. Columns 0-2 turn its directions (those of the first
/// shot, if it is rotational), 3-5 are the references, 6 is tau_k.
template <class T>
struct ShotRows {
  std::array<T, kShotReadings> e;
  std::array<std::array<T, 7>, kShotReadings> j;
};

template <class T>
ShotRows<T> rows_of(const ShotsModel& m, std::size_t k, const T* y, const State<T>& s, const References<T>& r) {
  const std::size_t own = m.rotational ? 0 : k;
  V3<T> u = s.down[own], n = s.north[own];
  std::array<V3<T>, 3> axes{{{T(1.0), T(0.0), T(0.0)}, {T(0.0), T(1.0), T(0.0)}, {T(0.0), T(0.0), T(1.0)}}};
  if (m.rotational && k > 0) {
    u = about_z(s.cosine[k], s.sine[k], u);
    n = about_z(s.cosine[k], s.sine[k], n);
    for (V3<T>& a : axes) a = about_z(s.cosine[k], s.sine[k], a);
  }
  const V3<T> h = combined(r.cosine, n, r.sine, u), north_down = combined(r.cosine, u, -r.sine, n);
  const V3<T> g = combined(r.gravity, u, T(0.0), u), b = combined(r.total, h, T(0.0), h);
  const double* sd = m.sd.data() + kShotReadings * k;
  const double* shared = m.sd.data() + kShotReadings * m.shots;
  ShotRows<T> out;
  for (std::size_t i = 0; i < kShotReadings; ++i) {
    const bool is_field = i >= 3;
    const std::size_t axis = is_field ? i - 3 : i;
    const T per(1 / sd[i]);
    out.e[i] = (y[i] - (is_field ? b[axis] : g[axis])) * per;
    for (std::size_t c = 0; c < 3; ++c) out.j[i][c] = cross3(axes[c], is_field ? b : g)[axis] * per;
    out.j[i][3] = is_field ? T(0.0) : u[axis] * (T(shared[0]) * per);
    out.j[i][4] = is_field ? h[axis] * (T(shared[1]) * per) : T(0.0);
    out.j[i][5] = is_field ? north_down[axis] * r.total * (T(shared[2]) * per) : T(0.0);
    out.j[i][6] = cross3(axes[2], is_field ? b : g)[axis] * per;
  }
  return out;
}

/// Number of a column of ShotRows among the unknowns: references or first shot first; nothing for tau of the first.
inline std::size_t column_of(const ShotsModel& m, std::size_t k, std::size_t c) {
  if (m.rotational) return c < 6 ? c : 5 + k;
  return c < 3 ? 3 + 3 * k + c : c - 3;
}
inline std::size_t columns_of_shot(const ShotsModel& m, std::size_t k) { return m.rotational && k > 0 ? 7 : 6; }
inline std::size_t reference_column(const ShotsModel& m, std::size_t j) { return m.rotational ? 3 + j : j; }

/// L of L L' = A by Cholesky; 1 / L_ii on the diagonal. Not finite where A is not positive definite.
template <class T>
void factor(std::size_t size, T* a) {
  for (std::size_t j = 0; j < size; ++j) {
    T* row = a + packed(j, 0);
    T d = row[j];
    for (std::size_t k = 0; k < j; ++k) d = fma(-row[k], row[k], d);
    row[j] = T(1.0) / sqrt(d);
    for (std::size_t i = j + 1; i < size; ++i) {
      T* other = a + packed(i, 0);
      T x = other[j];
      for (std::size_t k = 0; k < j; ++k) x = fma(-other[k], row[k], x);
      other[j] = x * row[j];
    }
  }
}
/// L^-1 x, from `first` on, before which x is zero.
template <class T>
void solve_lower(std::size_t size, const T* l, T* x, std::size_t first) {
  for (std::size_t i = first; i < size; ++i) {
    const T* row = l + packed(i, 0);
    for (std::size_t k = first; k < i; ++k) x[i] = fma(-row[k], x[k], x[i]);
    x[i] = x[i] * row[i];
  }
}
template <class T>
void solve_upper(std::size_t size, const T* l, T* x) {
  for (std::size_t i = size; i-- > 0;) {
    x[i] = x[i] * l[packed(i, i)];
    for (std::size_t k = 0; k < i; ++k) x[k] = fma(-l[packed(i, k)], x[i], x[k]);
  }
}

/// Directions that one shot's readings give.
template <class T>
void set_directions(const T* y, V3<T>& down, V3<T>& north) {
  const V3<T> g{y[0], y[1], y[2]}, b{y[3], y[4], y[5]};
  const T per_g = T(1.0) / sqrt(dot3(g, g));
  down = {g[0] * per_g, g[1] * per_g, g[2] * per_g};
  const V3<T> across = combined(T(1.0), b, -dot3(down, b), down);
  const T per = T(1.0) / sqrt(dot3(across, across));
  north = {across[0] * per, across[1] * per, across[2] * per};
}

template <class T>
State<T> start(const ShotsModel& m, const T* y) {
  State<T> s;
  s.zeta = {T(0.0), T(0.0), T(0.0)};
  for (std::size_t k = 0; k < m.shots; ++k) set_directions(y + kShotReadings * k, s.down[k], s.north[k]);
  s.cosine[0] = T(1.0);
  s.sine[0] = T(0.0);
  for (std::size_t k = 1; k < m.shots; ++k) {  // R = F_k F_0', the turn about z that is nearest to it
    const V3<T> e0 = cross3(s.down[0], s.north[0]), ek = cross3(s.down[k], s.north[k]);
    T across(0.0), along(0.0);
    for (const auto& [a, b] : {std::pair{s.north[k], s.north[0]}, std::pair{ek, e0}, std::pair{s.down[k], s.down[0]}}) {
      across = across + fma(a[1], b[0], -(a[0] * b[1]));
      along = along + fma(a[0], b[0], a[1] * b[1]);
    }
    const T per = T(1.0) / sqrt(fma(across, across, along * along));
    s.cosine[k] = along * per;
    s.sine[k] = across * per;
  }
  return s;
}

template <class T>
State<T> moved_by(const ShotsModel& m, const State<T>& from, const T* step) {
  State<T> s = from;
  for (std::size_t j = 0; j < 3; ++j) s.zeta[j] = s.zeta[j] + step[reference_column(m, j)];
  for (std::size_t k = 0; k < (m.rotational ? 1 : m.shots); ++k) {
    const std::size_t at = column_of(m, k, 0);
    const V3<T> phi{step[at], step[at + 1], step[at + 2]};
    s.down[k] = turned(phi, from.down[k]);
    s.north[k] = turned(phi, from.north[k]);
  }
  if (m.rotational)
    for (std::size_t k = 1; k < m.shots; ++k) {
      const T half = step[column_of(m, k, 6)] * T(0.5), square = half * half, per = T(1.0) / (T(1.0) + square);
      const T c = (T(1.0) - square) * per, sn = (half + half) * per;
      s.cosine[k] = fma(c, from.cosine[k], -(sn * from.sine[k]));
      s.sine[k] = fma(sn, from.cosine[k], c * from.sine[k]);
    }
  return s;
}

template <class T, class Mask>
void select_state(const Mask& mask, const State<T>& a, State<T>& b, std::size_t shots) {
  for (std::size_t k = 0; k < shots; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      b.down[k][i] = select(mask, a.down[k][i], b.down[k][i]);
      b.north[k][i] = select(mask, a.north[k][i], b.north[k][i]);
    }
    b.cosine[k] = select(mask, a.cosine[k], b.cosine[k]);
    b.sine[k] = select(mask, a.sine[k], b.sine[k]);
  }
  for (std::size_t i = 0; i < 3; ++i) b.zeta[i] = select(mask, a.zeta[i], b.zeta[i]);
}

/// The linear problem at a state: residuals and derivatives of all shots, the factor of J'J, and J'e.
template <class T>
struct ShotsLinearised {
  std::array<ShotRows<T>, kMostShots> rows;
  Symmetric<T, kMostShotUnknowns> normal;
  std::array<T, kMostShotUnknowns> gradient;
};

/// The normal matrix and its factor only where `with_matrix`; otherwise they stay.
template <class T>
void linearise(const ShotsModel& m, const T* y, const V3<T>& observed, const State<T>& s, bool with_matrix,
               ShotsLinearised<T>& l) {
  // Readings that a column has: gravity alone reaches the accelerometers, the total field alone the magnetometers.
  constexpr std::size_t kFrom[7] = {0, 0, 0, 0, 3, 0, 0}, kTo[7] = {6, 6, 6, 3, 6, 6, 6};
  const std::size_t unknowns = m.unknowns();
  if (with_matrix)
    for (std::size_t i = 0; i < packed(unknowns, 0); ++i) l.normal[i] = T(0.0);
  for (std::size_t i = 0; i < unknowns; ++i) l.gradient[i] = T(0.0);
  for (std::size_t j = 0; j < 3; ++j) {  // zeta is observed as 0
    const std::size_t c = reference_column(m, j);
    if (with_matrix) l.normal[packed(c, c)] = T(1.0);
    l.gradient[c] = -s.zeta[j];
  }
  const References<T> r = references_at(m, observed, s.zeta);
  for (std::size_t k = 0; k < m.shots; ++k) {
    l.rows[k] = rows_of(m, k, y + kShotReadings * k, s, r);
    const ShotRows<T>& rows = l.rows[k];
    for (std::size_t a = 0; a < columns_of_shot(m, k); ++a) {
      const std::size_t ca = column_of(m, k, a);
      T gradient = l.gradient[ca];
      for (std::size_t i = kFrom[a]; i < kTo[a]; ++i) gradient = fma(rows.j[i][a], rows.e[i], gradient);
      l.gradient[ca] = gradient;
      for (std::size_t b = 0; with_matrix && b <= a; ++b) {
        const std::size_t cb = column_of(m, k, b);
        T& normal = l.normal[ca > cb ? packed(ca, cb) : packed(cb, ca)];
        T n = normal;
        for (std::size_t i = kFrom[a] > kFrom[b] ? kFrom[a] : kFrom[b]; i < kTo[a] && i < kTo[b]; ++i)
          n = fma(rows.j[i][a], rows.j[i][b], n);
        normal = n;
      }
    }
  }
  if (with_matrix) factor(unknowns, l.normal.data());
}

}  // namespace shots_kernel

/// Adjusts the readings y (kShotReadings a shot) and the references `observed` (G, B, dip less the true dip), and tests
/// them. A lane that has converged is frozen, so that no lane depends on the others.
template <class T>
void adjust_and_test_shots(const ShotsModel& m, const T* y, const std::array<T, 3>& observed, ShotsTests<T>& t) {
  using namespace shots_kernel;
  constexpr int kMost = 30;
  constexpr double kTolerance = 1e-9;  // as in adjust(): sd of the observation that moves most
  const std::size_t unknowns = m.unknowns(), readings = kShotReadings * m.shots;
  State<T> s = start(m, y);
  ShotsLinearised<T> l;
  auto active = T(0.0) < T(1.0), converged = T(1.0) < T(0.0);
  for (int i = 0; i < kMost && any(active); ++i) {
    // The second matrix is that of the minimum but for a thousandth of the noise: it serves the steps that follow.
    // Should they be many, it is made anew.
    linearise(m, y, observed, s, i < 2 || i % 4 == 0, l);
    std::array<T, kMostShotUnknowns> step = l.gradient;
    solve_lower(unknowns, l.normal.data(), step.data(), 0);
    solve_upper(unknowns, l.normal.data(), step.data());
    T moved(0.0);  // a sum: NaN is not lost in it
    for (std::size_t j = 0; j < 3; ++j) moved = moved + abs(step[reference_column(m, j)]);
    for (std::size_t k = 0; k < m.shots; ++k)
      for (std::size_t o = 0; o < kShotReadings; ++o) {
        T x(0.0);
        for (std::size_t c = 0; c < columns_of_shot(m, k); ++c) x = fma(l.rows[k].j[o][c], step[column_of(m, k, c)], x);
        moved = moved + abs(x);
      }
    select_state(active, moved_by(m, s, step.data()), s, m.shots);
    converged = converged | (active & (moved <= T(kTolerance)));
    active = active & (moved > T(kTolerance));
  }

  linearise(m, y, observed, s, true, l);
  t.converged = select(converged, T(1.0), T(0.0));
  t.omega = t.largest = T(0.0);
  for (std::size_t o = 0; o < m.observations(); ++o) {
    T* v = t.base.data() + o * unknowns;
    for (std::size_t c = 0; c < unknowns; ++c) v[c] = T(0.0);
    T e;
    if (o < readings) {
      const std::size_t k = o / kShotReadings, i = o % kShotReadings;
      e = l.rows[k].e[i];
      for (std::size_t c = 0; c < columns_of_shot(m, k); ++c) v[column_of(m, k, c)] = l.rows[k].j[i][c];
      solve_lower(unknowns, l.normal.data(), v, 0);
    } else {
      e = -s.zeta[o - readings];
      v[reference_column(m, o - readings)] = T(1.0);
      solve_lower(unknowns, l.normal.data(), v, reference_column(m, o - readings));
    }
    T redundancy(1.0);
    for (std::size_t c = 0; c < unknowns; ++c) redundancy = fma(-v[c], v[c], redundancy);
    t.omega = fma(e, e, t.omega);
    t.w[o] = select(redundancy > T(kLeastRedundancy), e / sqrt(redundancy), T(0.0));
    t.largest = max(t.largest, abs(t.w[o]));
  }
}

}  // namespace surveymc::reliability
