#pragma once
/// Nonlinear adjustment of one station and all its tests, for any scalar type: lanes are trials.
///
/// The same Gauss-Newton steps as adjust() (adjustment.h), its oracle. Units are those of the field: readings g/G and
/// b/B, references G and B of 1, dip in rad, standard deviations alike. With v = y - adjusted y and the columns c of
/// the conditions at the adjusted readings (station_kernel.h),
///
///   w = f + sum c v,   N = (sum q c c')^-1,   residual_i = q_i c_i' N w,
///   w_i = c_i' N w / sqrt(c_i' N c_i),   Omega = w' N w,   rho_ij = c_i' N c_j / sqrt(c_i' N c_i  c_j' N c_j)
///
/// An observation z that is left out takes its direction with it: N - N z z' N / (z' N z).
#include <array>

#include "reliability/station_kernel.h"
#include "simd/math.h"

namespace surveymc::reliability {

using namespace simd;

inline constexpr std::size_t kStationObservations = 9;

/// Of the true observations; without_bz: adjusted as in sse_axial.
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
  T converged;  ///< 1, or 0: then the others mean nothing
};

namespace gross_error_kernel {

template <class T>
using ConditionColumn = std::array<T, 3>;

template <class T>
T dot3(const ConditionColumn<T>& a, const ConditionColumn<T>& b) {
  return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2]));
}

template <class T>
ConditionColumn<T> times(const Symmetric<T, 3>& n, const ConditionColumn<T>& c) {
  return {fma(n[0], c[0], fma(n[1], c[1], n[3] * c[2])), fma(n[1], c[0], fma(n[2], c[1], n[4] * c[2])),
          fma(n[3], c[0], fma(n[4], c[1], n[5] * c[2]))};
}

/// The linear problem at one set of observations.
template <class T>
struct Linearised {
  std::array<ConditionColumn<T>, kStationObservations> columns;
  Symmetric<T, 3> weight;          ///< N, what is left out taken off
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
  // dip - Theta by its sine: Theta is near the true dip. Beyond 30 degrees off it is not the angle, but of its sign.
  const auto [sd, cd] = sincos_reduced(at[8] - s.dip);
  const T sin_theta = fma(T(s.sin_dip), cd, T(s.cos_dip) * sd), cos_theta = fma(T(s.cos_dip), cd, -T(s.sin_dip) * sd);
  const T difference = fma(sine, cos_theta, -(cosine * sin_theta)), square = difference * difference;
  const T angle = difference * asin_ratio(select(square < T(0.25), square, T(0.25)));

  Linearised<T> l;
  const T zero(0.0), one(1.0);
  const std::array<T, 3> us{u.x, u.y, u.z}, hs{h.x, h.y, h.z};
  for (std::size_t i = 0; i < 3; ++i) {
    l.columns[i] = {us[i], zero, fma(-sine, us[i], hs[i]) * per_g * per_cosine};
    l.columns[3 + i] = {zero, hs[i], fma(-sine, hs[i], us[i]) * per_b * per_cosine};
  }
  l.columns[6] = {-one, zero, zero};
  l.columns[7] = {zero, -one, zero};
  l.columns[8] = {zero, zero, -one};

  Symmetric<T, 3> covariance{zero, zero, zero, zero, zero, zero};
  l.misclosures = {gravity - at[6], total - at[7], angle};
  for (std::size_t i = 0; i < kStationObservations; ++i) {
    const ConditionColumn<T>& c = l.columns[i];
    const T q(s.sd[i] * s.sd[i]), v = y[i] - at[i];
    for (std::size_t r = 0; r < 3; ++r) {
      l.misclosures[r] = fma(c[r], v, l.misclosures[r]);
      for (std::size_t k = 0; k <= r; ++k) covariance[packed(r, k)] = fma(q * c[r], c[k], covariance[packed(r, k)]);
    }
  }
  l.weight = station_kernel::inverse<T>(covariance);
  l.bz = zero;
  if (s.without_bz) {
    const ConditionColumn<T>& z = l.columns[5];
    const ConditionColumn<T> nz = times(l.weight, z);
    const T information = dot3(z, nz);
    const T per = select(information * T(s.sd[5] * s.sd[5]) > T(kLeastRedundancy), one / information, zero);
    l.bz = dot3(nz, l.misclosures) * per;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k <= r; ++k) l.weight[packed(r, k)] = fma(-(nz[r] * per), nz[k], l.weight[packed(r, k)]);
  }
  return l;
}

}  // namespace gross_error_kernel

/// Adjusts the observations y and tests them. A lane that has converged is left as it is, so that no lane depends on
/// its neighbours.
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
    for (std::size_t o = 0; o < kStationObservations; ++o) {
      T next = fma(T(-s.sd[o] * s.sd[o]), dot3(l.columns[o], k), y[o]);
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
  for (std::size_t o = 0; o < kStationObservations; ++o) {
    const ConditionColumn<T> nc = times(l.weight, l.columns[o]);
    const T information = dot3(l.columns[o], nc);
    auto testable = information * T(s.sd[o] * s.sd[o]) > T(kLeastRedundancy);
    if (s.without_bz && o == 5) testable = T(1.0) < T(0.0);
    per_size[o] = select(testable, T(1.0) / sqrt(information), T(0.0));
    t.w[o] = select(testable, dot3(l.columns[o], k) * per_size[o], T(0.0));
    const auto more = abs(t.w[o]) > t.largest;
    t.largest = select(more, abs(t.w[o]), t.largest);
    for (std::size_t r = 0; r < 3; ++r) worst[r] = select(more, nc[r] * per_size[o], worst[r]);
  }
  t.tied = T(0.0);
  for (std::size_t o = 0; o < kStationObservations; ++o)
    t.tied = t.tied + select(abs(dot3(l.columns[o], worst) * per_size[o]) > T(1 - 1e-9), T(double(1 << o)), T(0.0));
  return t;
}

}  // namespace surveymc::reliability
