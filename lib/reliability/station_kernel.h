#pragma once
/// Reliability of all observations of one station, for any scalar type: the arithmetic of reliability maps.
///
/// Readings in units of the field, u = g/G (down), h = b/B = cosD n + sinD u with n, e, u an orthonormal base (north,
/// east, down), D the dip. Three conditions hold among error-free observations (conditions.h). Their derivatives are
///
///   by g/G:  (u, 0, n)    by b/B:  (0, h, m), m = cosD u - sinD n    by (dG/G, dB/B, dD):  minus the unit matrix
///
/// so nothing is singular in a vertical hole, and three equations take the place of the paper's 9 x 6 design matrix.
///   M_0 = sum over the readings of v c c'   (c: a column above, v: its relative variance, eq 22)
///   T   = covariance of the quantities that the N stations share: references, and systematic terms if estimated
/// The misclosures of N stations at one attitude have the covariance M_0 on the diagonal and T everywhere. Its inverse
/// has W = ((N-1) M_0^-1 + W_N) / N on the diagonal and rows that add up to W_N = (M_0 + N T)^-1; one station: W = W_N.
///
/// For the observation with column c:  N_ii = c'Wc,  r_i = v N_ii (eq 21),  nabla_0 = lambda_0 / sqrt(N_ii) (eq 19).
/// An error causes the residuals v_j c_j' W c. The rest of the error, after these residuals are subtracted, turns the
/// attitude: external reliability without (X'PX)^-1.
#include <array>
#include <limits>

#include "simd/solve.h"
#include "survey/frames.h"

namespace surveymc::reliability {

using namespace simd;

/// Sines and cosines of inclination, toolface (from y), magnetic azimuth and dip.
template <class T>
struct StationSines {
  T si, ci, st, ct, sa, ca, sd, cd;
};

/// Relative variances (of g/G, b/B, dG/G, dB/B, and of the dip in rad2) and lambda_0. N: double, or the kernel's type,
/// so that a loop over points broadcasts them once.
template <class N>
struct StationVariancesOf {
  N g_noise, g_bias, g_scale, b_noise, b_bias, bz_bias, b_scale;
  N gravity, total_field, dip;
  double stations;  ///< N
  N lambda0;
};
using StationVariances = StationVariancesOf<double>;

/// Effects on the parameters of an error of +`detectable` in one observation: rad, and relative for gravity and
/// total field. `detectable` is relative too, rad for the dip.
template <class T>
struct ObservationReliability {
  T redundancy, detectable, inclination, toolface, azimuth, gravity, total_field, dip;
};

/// The variant of the model that a kernel is compiled for.
struct StationModel {
  bool bias_is_random;    ///< eq 22 whole (sse); otherwise the noise alone
  bool references;        ///< true: observed; false: free of error
  bool shared;            ///< N stations
  bool systematic_terms;  ///< estimated for all stations together
  bool axial;             ///< bz is left out
};

inline constexpr StationModel kSseModel{true, true, false, false, false};
inline constexpr StationModel kSseAxialModel{true, true, false, false, true};
inline constexpr StationModel kMseFixedModel{false, false, false, false, false};
inline constexpr StationModel kMseSharedModel{false, true, true, false, false};
inline constexpr StationModel kMseSystematicModel{false, true, true, true, false};

inline constexpr double kLeastRedundancy = 1e-10;  ///< below, an observation is not controlled at all: r = 0

namespace station_kernel {

template <class T>
using Matrix3 = Symmetric<T, 3>;

/// Inverse of a positive definite matrix.
template <class T>
[[gnu::always_inline]] inline Matrix3<T> inverse(const Matrix3<T>& m) {
  const Matrix3<T> f = ldlt<T, 3>(m);                                     // 1/D on the diagonal, L below it
  const T l31 = fma(f[packed(1, 0)], f[packed(2, 1)], -f[packed(2, 0)]);  // (L^-1)_31
  const T d2 = f[packed(1, 1)], d3 = f[packed(2, 2)];
  const T a = -f[packed(1, 0)], c = -f[packed(2, 1)];  // (L^-1)_21, (L^-1)_32
  return {fma(a * a, d2, fma(l31 * l31, d3, f[packed(0, 0)])),
          fma(a, d2, l31 * c * d3),
          fma(c * c, d3, d2),
          l31 * d3,
          c * d3,
          d3};
}

template <class T>
survey::Vec3<T> times(const Matrix3<T>& m, const survey::Vec3<T>& x) {
  return {fma(m[0], x.x, fma(m[1], x.y, m[3] * x.z)), fma(m[1], x.x, fma(m[2], x.y, m[4] * x.z)),
          fma(m[3], x.x, fma(m[4], x.y, m[5] * x.z))};
}

/// sum of weights . a . b over the three axes
template <class T>
T sum(const survey::Vec3<T>& v, const survey::Vec3<T>& a, const survey::Vec3<T>& b) {
  return fma(v.x * a.x, b.x, fma(v.y * a.y, b.y, v.z * a.z * b.z));
}

/// Sums over the readings of relative variances times their effect on the attitude, by kind of condition.
template <class T>
struct Turns {
  T inclination_u, inclination_n, across_u, across_n, east_u, east_n, east_h, east_m;
};
template <class T>
[[gnu::always_inline]] inline Turns<T> turns(const survey::Vec3<T>& vg, const survey::Vec3<T>& vb,
                                             const survey::Vec3<T>& iota, const survey::Vec3<T>& tau,
                                             const survey::Vec3<T>& u, const survey::Vec3<T>& n,
                                             const survey::Vec3<T>& e, const survey::Vec3<T>& h,
                                             const survey::Vec3<T>& m) {
  return {sum(vg, iota, u), sum(vg, iota, n), sum(vg, tau, u), sum(vg, tau, n),
          sum(vg, e, u),    sum(vg, e, n),    sum(vb, e, h),   sum(vb, e, m)};
}

template <class T>
[[gnu::always_inline]] inline Matrix3<T> covariance(const survey::Vec3<T>& vg, const survey::Vec3<T>& vb,
                                                    const survey::Vec3<T>& u, const survey::Vec3<T>& n,
                                                    const survey::Vec3<T>& h, const survey::Vec3<T>& m) {
  return {sum(vg, u, u), T(0.0), sum(vb, h, h), sum(vg, u, n), sum(vb, h, m), sum(vg, n, n) + sum(vb, m, m)};
}

/// x * factor, but 0 where x is only a rounding error: sizes below 1e-12 of the effect of one sd do not count when the
/// factor is infinite.
template <class T>
T times_maybe_infinite(const T& x, const T& factor, const T& variance) {
  const T infinity = T(std::numeric_limits<double>::infinity());
  const auto finite = abs(factor) < infinity;
  const auto nothing = x * x * variance <= T(1e-24);
  return select(finite, x * select(finite, factor, T(1.0)), select(nothing, T(0.0), x * factor));
}

}  // namespace station_kernel

/// Calls use(i, ObservationReliability<T>) for every observation i whose bit is set in `wanted` (those that the model
/// does not observe must not be). noise2: factor on the variance of the noise. Effects on gravity, total field and dip
/// are computed only where `reference_effects`, and zero otherwise.
template <class T, StationModel kModel, class Variance, class Use>
void station_reliability(const StationSines<T>& s, const T& noise2, const StationVariancesOf<Variance>& v,
                         unsigned wanted, bool reference_effects, const Use& use) {
  using namespace station_kernel;
  const survey::Vec3<T> u{-s.si * s.st, -s.si * s.ct, s.ci};
  const T north_across = s.ci * s.ca;
  const survey::Vec3<T> n{fma(north_across, s.st, s.sa * s.ct), fms(north_across, s.ct, s.sa * s.st), s.si * s.ca};
  const survey::Vec3<T> e = cross(u, n);
  const survey::Vec3<T> h{fma(s.cd, n.x, s.sd * u.x), fma(s.cd, n.y, s.sd * u.y), fma(s.cd, n.z, s.sd * u.z)};
  const survey::Vec3<T> m{fms(s.cd, u.x, s.sd * n.x), fms(s.cd, u.y, s.sd * n.y), fms(s.cd, u.z, s.sd * n.z)};
  const survey::Vec3<T> iota{-s.ci * s.st, -s.ci * s.ct, -s.si};  // du/dI
  const survey::Vec3<T> tau{-s.ct, s.st, T(0.0)};  // du/dtau / sinI: horizontal, to the right of the hole's azimuth

  const T ng = T(v.g_noise) * noise2, nb = T(v.b_noise) * noise2;
  const auto systematic = [](const T& bias, const Variance& scale, const T& x) { return fma(T(scale) * x, x, bias); };
  const survey::Vec3<T> sg{systematic(T(v.g_bias), v.g_scale, u.x), systematic(T(v.g_bias), v.g_scale, u.y),
                           systematic(T(v.g_bias), v.g_scale, u.z)};
  const survey::Vec3<T> sb{systematic(T(v.b_bias), v.b_scale, h.x), systematic(T(v.b_bias), v.b_scale, h.y),
                           systematic(T(v.bz_bias), v.b_scale, h.z)};
  survey::Vec3<T> vg{ng, ng, ng}, vb{nb, nb, nb};
  if constexpr (kModel.bias_is_random) {
    vg = vg + sg;
    vb = vb + sb;
  }
  if constexpr (kModel.axial) vb.z = T(0.0);

  Matrix3<T> own = covariance(vg, vb, u, n, h, m);
  Matrix3<T> common{};
  if constexpr (kModel.references) common = {T(v.gravity), T(0.0), T(v.total_field), T(0.0), T(0.0), T(v.dip)};
  if constexpr (kModel.systematic_terms) {
    const Matrix3<T> more = covariance(sg, sb, u, n, h, m);
    for (std::size_t k = 0; k < more.size(); ++k) common[k] = common[k] + more[k];
  }
  const double count = kModel.shared ? v.stations : 1;
  Matrix3<T> of_all = own;
  if constexpr (kModel.references)
    for (std::size_t k = 0; k < of_all.size(); ++k) of_all[k] = fma(T(count), common[k], own[k]);
  Matrix3<T> w_sum = inverse(of_all), w = w_sum;
  if constexpr (kModel.shared) {
    if (count > 1) {  // the same for all lanes
      const Matrix3<T> w0 = inverse(own);
      for (std::size_t k = 0; k < w.size(); ++k) w[k] = fma(T(count - 1), w0[k], w_sum[k]) * T(1 / count);
    }
  }

  // Without bz the conditions lose the direction in which its unknown error moves them.
  const survey::Vec3<T> z{T(0.0), h.z, m.z};
  survey::Vec3<T> wz{T(0.0), T(0.0), T(0.0)};
  T per_zwz = T(0.0);
  if constexpr (kModel.axial) {
    const survey::Vec3<T> before = times(w, z);
    const T zwz = dot(z, before);
    // bz does not enter the conditions (horizontal, east or west), and was the only information on the azimuth
    const auto azimuth_is_lost = zwz * (nb + sb.z) < T(kLeastRedundancy);
    per_zwz = select(azimuth_is_lost, T(std::numeric_limits<double>::infinity()), T(1.0) / zwz);
    const T scale_z = select(azimuth_is_lost, T(0.0), T(1.0) / zwz);
    wz = before;
    w[0] = fma(-wz.x * scale_z, wz.x, w[0]);
    w[1] = fma(-wz.y * scale_z, wz.x, w[1]);
    w[2] = fma(-wz.y * scale_z, wz.y, w[2]);
    w[3] = fma(-wz.z * scale_z, wz.x, w[3]);
    w[4] = fma(-wz.z * scale_z, wz.y, w[4]);
    w[5] = fma(-wz.z * scale_z, wz.z, w[5]);
    w_sum = w;
  }

  const Turns<T> c = turns(vg, vb, iota, tau, u, n, e, h, m);
  Turns<T> cs{};
  if constexpr (kModel.systematic_terms) cs = turns(sg, sb, iota, tau, u, n, e, h, m);
  const bool not_vertical = all(T(0.0) < abs(s.si));
  const T per_si = T(1.0) / abs(s.si), per_cd = T(1.0) / s.cd;  // abs: -0 must not turn the sign of an infinity

  // The tool turns about the vertical by (e.dh - sinD e.du)/cosD: the part that the residuals subtract, per k
  const T turn_g = s.sd * per_cd;
  const auto turned_by = [&](const Turns<T>& t) {
    return survey::Vec3<T>{turn_g * t.east_u, -t.east_h * per_cd, fms(turn_g, t.east_n, t.east_m * per_cd)};
  };
  const survey::Vec3<T> turn_k = turned_by(c);
  survey::Vec3<T> turn_ks{T(0.0), T(0.0), T(0.0)};
  if constexpr (kModel.systematic_terms) turn_ks = turned_by(cs);

  const T one = T(1.0), none = T(0.0);
  const std::array<T, 6> first{u.x, u.y, u.z, h.x, h.y, h.z};      // entries of a reading's column: gravity or field,
  const std::array<T, 6> dip_entry{n.x, n.y, n.z, m.x, m.y, m.z};  // and dip
  const std::array<T, 9> variance{vg.x, vg.y, vg.z, vb.x, vb.y, vb.z, T(v.gravity), T(v.total_field), T(v.dip)};
  const std::array<T, 6> own_inclination{iota.x, iota.y, iota.z, none, none, none},
      own_across{tau.x, tau.y, none, none, none, none}, own_east{e.x, e.y, e.z, e.x, e.y, e.z};
  // Columns have zeros: gravity and total field of the readings, all but one entry of the references
  const auto weighted = [&](const Matrix3<T>& m3, std::size_t i) {
    if (i == 6) return survey::Vec3<T>{-m3[0], -m3[1], -m3[3]};
    if (i == 7) return survey::Vec3<T>{-m3[1], -m3[2], -m3[4]};
    if (i == 8) return survey::Vec3<T>{-m3[3], -m3[4], -m3[5]};
    const std::size_t row = i < 3 ? 0 : 1;
    return survey::Vec3<T>{fma(m3[packed(row, 0)], first[i], m3[3] * dip_entry[i]),
                           fma(m3[packed(1, row)], first[i], m3[4] * dip_entry[i]),
                           fma(m3[packed(2, row)], first[i], m3[5] * dip_entry[i])};
  };
  const auto along = [&](const survey::Vec3<T>& x, std::size_t i) {
    if (i == 6) return -x.x;
    if (i == 7) return -x.y;
    if (i == 8) return -x.z;
    return fma(i < 3 ? x.x : x.y, first[i], x.z * dip_entry[i]);
  };

#pragma GCC unroll 9
  for (std::size_t i = 0; i < 9; ++i) {
    if ((wanted >> i & 1) == 0) continue;
    const bool reference = i >= 6;
    survey::Vec3<T> k = weighted(reference ? w_sum : w, i);
    T information = along(k, i);
    if (reference) information = information * T(count);
    ObservationReliability<T> r;
    const T share = information * variance[i];
    const auto controlled = T(kLeastRedundancy) <= share;
    r.redundancy = select(controlled, share, none);
    r.detectable = select(controlled, T(v.lambda0) / sqrt(select(controlled, information, one)),
                          T(std::numeric_limits<double>::infinity()));

    // Nearly all points are plain. A point that is not sends all lanes the longer way, which gives plain points the
    // same bits.
    const bool plain = not_vertical && all(controlled);
    // An error that no residual shows goes into the estimates in full.
    const auto where_controlled = [&](const survey::Vec3<T>& x) {
      if (plain) return x;
      return survey::Vec3<T>{select(controlled, x.x, none), select(controlled, x.y, none),
                             select(controlled, x.z, none)};
    };
    const auto times_size = [&](const T& x, const T& factor) {
      return plain ? x * factor : times_maybe_infinite(x, factor, variance[i]);
    };
    k = where_controlled(k);
    survey::Vec3<T> ks = k;  // summed over the stations
    if constexpr (kModel.shared) {
      if (reference) {
        ks = scale(T(count), k);
      } else {
        ks = where_controlled(weighted(w_sum, i));
      }
    }
    T inclination = -fma(k.x, c.inclination_u, k.z * c.inclination_n), across = -fma(k.x, c.across_u, k.z * c.across_n),
      turn = -fma(k.x, turn_k.x, fma(k.y, turn_k.y, k.z * turn_k.z));
    if constexpr (kModel.systematic_terms) {
      inclination = inclination - fma(ks.x, cs.inclination_u, ks.z * cs.inclination_n);
      across = across - fma(ks.x, cs.across_u, ks.z * cs.across_n);
      turn = turn - fma(ks.x, turn_ks.x, fma(ks.y, turn_ks.y, ks.z * turn_ks.z));
    }
    if (i < 3) {
      inclination = inclination + own_inclination[i];
      across = across + own_across[i];
      turn = fma(turn_g, own_east[i], turn);
    } else if (i < 6) {
      turn = fma(-own_east[i], per_cd, turn);
    }
    if constexpr (kModel.axial) {
      // what the other observations leave for bz, whose estimate takes the place of its reading
      const T push = along(wz, i);
      turn =
          turn + e.z * per_cd * select(per_zwz < T(std::numeric_limits<double>::infinity()), push * per_zwz, per_zwz);
    }
    // Leaning to the right of the hole by `across` makes toolface and azimuth move against each other.
    const T toolface = times_size(across, per_si);
    r.inclination = times_size(inclination, r.detectable);
    r.toolface = times_size(toolface, r.detectable);
    r.azimuth = times_size(fma(-s.ci, toolface, turn), r.detectable);
    r.gravity = r.total_field = r.dip = none;
    if (kModel.references && reference_effects) {
      r.gravity = times_size(T(v.gravity) * ks.x + T(i == 6 ? 1.0 : 0.0), r.detectable);
      r.total_field = times_size(T(v.total_field) * ks.y + T(i == 7 ? 1.0 : 0.0), r.detectable);
      r.dip = times_size(T(v.dip) * ks.z + T(i == 8 ? 1.0 : 0.0), r.detectable);
    }
    use(i, r);
  }
}

}  // namespace surveymc::reliability
