#pragma once
/// Nonlinear adjustment of one station and all its tests, for any scalar type: lanes are trials.
///
/// The Gauss-Newton steps are those of adjust() (adjustment.h), with which tests compare this kernel. Units are those
/// of the field: readings g/G and b/B, references G and B of 1, dip in rad, standard deviations alike. With v = y -
/// adjusted y and the columns c of the conditions at the adjusted readings (station_kernel.h),
///
///   w = f + sum c v,   N = (sum q c c')^-1,   residual_i = q_i c_i' N w,
///   w_i = c_i' N w / sqrt(c_i' N c_i),   Omega = w' N w,   rho_ij = c_i' N c_j / sqrt(c_i' N c_i  c_j' N c_j)
///
/// An observation z that is left out removes its direction from N: N - N z z' N / (z' N z).
#include <array>

#include "reliability/station_kernel.h"
#include "simd/math.h"

namespace surveymc::reliability {

using namespace simd;

inline constexpr std::size_t kStationObservations = 9;

/// Sizes of the true observations; without_bz: adjusted as in sse_axial.
struct StationScale {
  std::array<double, kStationObservations> sd;  ///< relative; 0 for references that are free of error
  double sin_dip, cos_dip, dip;                 ///< of the true reference dip
  bool without_bz;
};

/// Tests of one adjusted station. w = 0: cannot be tested (r < 1e-10).
template <class T>
struct StationTests {
  std::array<T, kStationObservations> w;
  T omega;
  T largest;    ///< |w| of the largest test
  T tied;       ///< sum of 2^i over the observations i whose tests have |rho| > 1 - 1e-9 with that one
  T converged;  ///< 1, or 0: then the other members have no meaning
};

namespace gross_error_kernel {

template <class T>
using ConditionColumn = std::array<T, 3>;

/// Readings enter one condition by their direction and that of the dip: columns (u_i, 0, u_dip_i) and (0, h_i,
/// h_dip_i). Those of the references are less the unit vectors. No sum is made over their zeros.
template <class T>
struct Columns {
  std::array<T, 6> first, dip;

  /// c_i' k
  T along(std::size_t i, const ConditionColumn<T>& k) const {
    if (i >= 6) return -k[i - 6];
    return fma(first[i], k[i < 3 ? 0 : 1], dip[i] * k[2]);
  }
  /// n c_i
  ConditionColumn<T> times(const Symmetric<T, 3>& n, std::size_t i) const {
    if (i == 6) return {-n[0], -n[1], -n[3]};
    if (i == 7) return {-n[1], -n[2], -n[4]};
    if (i == 8) return {-n[3], -n[4], -n[5]};
    const std::size_t row = i < 3 ? 0 : 1;
    return {fma(n[packed(row, 0)], first[i], n[3] * dip[i]), fma(n[packed(1, row)], first[i], n[4] * dip[i]),
            fma(n[packed(2, row)], first[i], n[5] * dip[i])};
  }
};

template <class T>
ConditionColumn<T> times(const Symmetric<T, 3>& n, const ConditionColumn<T>& c) {
  return {fma(n[0], c[0], fma(n[1], c[1], n[3] * c[2])), fma(n[1], c[0], fma(n[2], c[1], n[4] * c[2])),
          fma(n[3], c[0], fma(n[4], c[1], n[5] * c[2]))};
}
template <class T>
T dot3(const ConditionColumn<T>& a, const ConditionColumn<T>& b) {
  return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2]));
}

/// The linear problem at one set of observations.
template <class T>
struct Linearised {
  Columns<T> columns;
  Symmetric<T, 3> weight;          ///< N, without the directions of observations left out
  ConditionColumn<T> misclosures;  ///< w
  T bz;                            ///< estimated error of bz where it is left out; else 0
};

template <class T>
Linearised<T> linearise(const StationScale& s, const std::array<T, kStationObservations>& y,
                        const std::array<T, kStationObservations>& at) {
  const survey::Vec3<T> g{at[0], at[1], at[2]}, b{at[3], at[4], at[5]};
  const T gravity = norm(g), total = norm(b), per_g = T(1.0) / gravity, per_b = T(1.0) / total;
  const survey::Vec3<T> u = scale(per_g, g), h = scale(per_b, b);
  const T sine = dot(u, h), cosine = norm(cross(u, h)), per_cosine = T(1.0) / cosine;
  // dip - Theta by its sine, as Theta is near the true dip. Beyond 30 degrees the value is no longer the angle, but
  // keeps its sign.
  const auto [sd, cd] = sincos_reduced(at[8] - s.dip);
  const T sin_theta = fma(T(s.sin_dip), cd, T(s.cos_dip) * sd), cos_theta = fma(T(s.cos_dip), cd, -T(s.sin_dip) * sd);
  const T difference = fma(sine, cos_theta, -(cosine * sin_theta)), square = difference * difference;
  const T angle = difference * asin_ratio(select(square < T(0.25), square, T(0.25)));

  Linearised<T> l;
  const T zero(0.0), one(1.0), dip_g = per_g * per_cosine, dip_b = per_b * per_cosine;
  const std::array<T, 3> us{u.x, u.y, u.z}, hs{h.x, h.y, h.z};
  for (std::size_t i = 0; i < 3; ++i) {
    l.columns.first[i] = us[i];
    l.columns.dip[i] = fma(-sine, us[i], hs[i]) * dip_g;
    l.columns.first[3 + i] = hs[i];
    l.columns.dip[3 + i] = fma(-sine, hs[i], us[i]) * dip_b;
  }

  Symmetric<T, 3> covariance{T(s.sd[6] * s.sd[6]), zero, T(s.sd[7] * s.sd[7]), zero, zero, T(s.sd[8] * s.sd[8])};
  // Less the references: f and their own part of sum c v, which is at - y, together
  l.misclosures = {gravity - y[6], total - y[7], angle - (y[8] - at[8])};
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t row = i < 3 ? 0 : 1;
    const T first = l.columns.first[i], dip = l.columns.dip[i], q(s.sd[i] * s.sd[i]), v = y[i] - at[i];
    const T q_first = q * first;
    l.misclosures[row] = fma(first, v, l.misclosures[row]);
    l.misclosures[2] = fma(dip, v, l.misclosures[2]);
    covariance[packed(row, row)] = fma(q_first, first, covariance[packed(row, row)]);
    covariance[packed(2, row)] = fma(q_first, dip, covariance[packed(2, row)]);
    covariance[5] = fma(q * dip, dip, covariance[5]);
  }
  l.weight = station_kernel::inverse<T>(covariance);
  l.bz = zero;
  if (s.without_bz) {
    const ConditionColumn<T> nz = l.columns.times(l.weight, 5);
    const T information = l.columns.along(5, nz);
    const T per = select(information * T(s.sd[5] * s.sd[5]) > T(kLeastRedundancy), one / information, zero);
    l.bz = dot3(nz, l.misclosures) * per;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k <= r; ++k) l.weight[packed(r, k)] = fma(-(nz[r] * per), nz[k], l.weight[packed(r, k)]);
  }
  return l;
}

}  // namespace gross_error_kernel

/// Adjusts the observations y and tests them. A lane that has converged is frozen, so that no lane depends on the
/// others.
template <class T>
StationTests<T> adjust_and_test(const StationScale& s, const std::array<T, kStationObservations>& y) {
  using namespace gross_error_kernel;
  constexpr int kMost = 100;
  constexpr double kTolerance = 1e-9;  // as in adjust(): sd of the observation that moves most
  std::array<T, kStationObservations> at = y;
  auto active = T(0.0) < T(1.0), converged = T(1.0) < T(0.0);
  for (int i = 0; i < kMost && any(active); ++i) {
    const Linearised<T> l = linearise<T>(s, y, at);
    const ConditionColumn<T> k = times(l.weight, l.misclosures);
    T step(0.0);
#pragma GCC unroll 9
    for (std::size_t o = 0; o < kStationObservations; ++o) {
      T next = fma(T(-s.sd[o] * s.sd[o]), l.columns.along(o, k), y[o]);
      if (s.without_bz && o == 5) next = y[o] - l.bz;
      if (s.sd[o] > 0) step = step + abs(next - at[o]) * T(1 / s.sd[o]);  // their sum: NaN is not lost in it
      at[o] = select(active, next, at[o]);
    }
    converged = converged | (active & (step <= T(kTolerance)));
    active = active & (step > T(kTolerance));
  }

  const Linearised<T> l = linearise<T>(s, y, at);
  const ConditionColumn<T> k = times(l.weight, l.misclosures);
  StationTests<T> t;
  t.omega = dot3(l.misclosures, k);
  t.largest = T(0.0);
  t.converged = select(converged, T(1.0), T(0.0));
  std::array<T, kStationObservations> per_size;
  ConditionColumn<T> worst{T(0.0), T(0.0), T(0.0)};  // unit column of the largest test, times N
#pragma GCC unroll 9
  for (std::size_t o = 0; o < kStationObservations; ++o) {
    const ConditionColumn<T> nc = l.columns.times(l.weight, o);
    const T information = l.columns.along(o, nc);
    auto testable = information * T(s.sd[o] * s.sd[o]) > T(kLeastRedundancy);
    if (s.without_bz && o == 5) testable = T(1.0) < T(0.0);
    per_size[o] = select(testable, T(1.0) / sqrt(information), T(0.0));
    t.w[o] = select(testable, l.columns.along(o, k) * per_size[o], T(0.0));
    const auto more = abs(t.w[o]) > t.largest;
    t.largest = select(more, abs(t.w[o]), t.largest);
    for (std::size_t r = 0; r < 3; ++r) worst[r] = select(more, nc[r] * per_size[o], worst[r]);
  }
  t.tied = T(0.0);
#pragma GCC unroll 9
  for (std::size_t o = 0; o < kStationObservations; ++o)
    t.tied = t.tied + select(abs(l.columns.along(o, worst) * per_size[o]) > T(1 - 1e-9), T(double(1 << o)), T(0.0));
  return t;
}

}  // namespace surveymc::reliability
