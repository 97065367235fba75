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

#include "simd/root.h"
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
inline constexpr double kLeastSine = 1e-12;        ///< of the inclination; below, the hole is vertical

namespace station_kernel {

template <class T>
using Matrix3 = Symmetric<T, 3>;

/// Inverse of a positive definite matrix whose element (1, 0) is zero: no condition but that of the dip has both
/// gravity and field in it. By cofactors, with one division; all conditions are of order one.
template <class T>
[[gnu::always_inline]] inline Matrix3<T> inverse(const Matrix3<T>& m) {
  const T a = m[0], b = m[2], d = m[3], e = m[4], f = m[5];
  const T of_a = fms(b, f, e * e), bd = b * d;
  const T per_determinant = T(1.0) / fms(a, of_a, d * bd);
  return {of_a * per_determinant, d * e * per_determinant,    fms(a, f, d * d) * per_determinant,
          -bd * per_determinant,  -(a * e) * per_determinant, a * b * per_determinant};
}

template <class T>
survey::Vec3<T> times(const Matrix3<T>& m, const survey::Vec3<T>& x) {
  return {fma(m[0], x.x, fma(m[1], x.y, m[3] * x.z)), fma(m[1], x.x, fma(m[2], x.y, m[4] * x.z)),
          fma(m[3], x.x, fma(m[4], x.y, m[5] * x.z))};
}
/// m (x, 0, z)
template <class T>
survey::Vec3<T> times_xz(const Matrix3<T>& m, const T& x, const T& z) {
  return {fma(m[0], x, m[3] * z), fma(m[1], x, m[4] * z), fma(m[3], x, m[5] * z)};
}

template <class T>
survey::Vec3<T> elementwise(const survey::Vec3<T>& a, const survey::Vec3<T>& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// Directions of a station in the tool frame: the columns of the conditions, and how the attitude turns.
template <class T>
struct Directions {
  survey::Vec3<T> u, n, e, h, m;
  survey::Vec3<T> iota;  ///< du/dI
  survey::Vec3<T> tau;   ///< du/dtau / sinI: horizontal, to the right of the hole's azimuth; tau.z = 0
};

/// Sums over the readings of relative variances: covariance of the conditions, and their products with the effects of
/// the readings on the attitude, by kind of condition.
template <class T>
struct Sums {
  Matrix3<T> covariance;
  T inclination_u, inclination_n, across_u, across_n, east_u, east_n, east_h, east_m;
};
template <class T>
[[gnu::always_inline]] inline Sums<T> sums(const survey::Vec3<T>& vg, const survey::Vec3<T>& vb,
                                           const Directions<T>& d) {
  const survey::Vec3<T> u = elementwise(vg, d.u), n = elementwise(vg, d.n), h = elementwise(vb, d.h),
                        m = elementwise(vb, d.m);
  const auto across = [&](const survey::Vec3<T>& x) { return fma(x.x, d.tau.x, x.y * d.tau.y); };
  return {{dot(u, d.u), T(0.0), dot(h, d.h), dot(u, d.n), dot(h, d.m), dot(n, d.n) + dot(m, d.m)},
          dot(u, d.iota),
          dot(n, d.iota),
          across(u),
          across(n),
          dot(u, d.e),
          dot(n, d.e),
          dot(h, d.e),
          dot(m, d.e)};
}

/// What the residuals of an error with column c subtract from its effect on the attitude: f'c, f for a reading and for
/// a reference.
template <class T>
struct Subtracted {
  survey::Vec3<T> reading, reference;
};
/// f1 + factor f2
template <class T>
[[gnu::always_inline]] inline Subtracted<T> plus(const Subtracted<T>& f1, const T& factor, const Subtracted<T>& f2) {
  const auto sum = [&](const survey::Vec3<T>& a, const survey::Vec3<T>& b) {
    return survey::Vec3<T>{fma(factor, b.x, a.x), fma(factor, b.y, a.y), fma(factor, b.z, a.z)};
  };
  return {sum(f1.reading, f2.reading), sum(f1.reference, f2.reference)};
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
/// does not observe must not be). noise2: factor on the variance of the noise. Effects on inclination, toolface and
/// azimuth are multiplied by `angle_unit`. Effects on gravity, total field and dip are computed only where
/// `reference_effects`, and zero otherwise.
template <class T, StationModel kModel, class Variance, class Use>
void station_reliability(const StationSines<T>& s, const T& noise2, const StationVariancesOf<Variance>& v,
                         unsigned wanted, bool reference_effects, const T& angle_unit, const Use& use) {
  using namespace station_kernel;
  using Vec = survey::Vec3<T>;
  const T one = T(1.0), none = T(0.0), infinity = T(std::numeric_limits<double>::infinity());
  const Vec u{-s.si * s.st, -s.si * s.ct, s.ci};
  const T north_across = s.ci * s.ca;
  const Vec n{fma(north_across, s.st, s.sa * s.ct), fms(north_across, s.ct, s.sa * s.st), s.si * s.ca};
  const Vec e = cross(u, n);
  const Vec h{fma(s.cd, n.x, s.sd * u.x), fma(s.cd, n.y, s.sd * u.y), fma(s.cd, n.z, s.sd * u.z)};
  const Vec m{fms(s.cd, u.x, s.sd * n.x), fms(s.cd, u.y, s.sd * n.y), fms(s.cd, u.z, s.sd * n.z)};
  const Directions<T> d{u, n, e, h, m, {-s.ci * s.st, -s.ci * s.ct, -s.si}, {-s.ct, s.st, none}};

  const T ng = T(v.g_noise) * noise2, nb = T(v.b_noise) * noise2;
  const auto systematic = [](const T& bias, const Variance& scale, const T& x) { return fma(T(scale) * x, x, bias); };
  const auto all_systematic = [&](const T& bias, const T& bias_z, const Variance& scale, const Vec& x) {
    return Vec{systematic(bias, scale, x.x), systematic(bias, scale, x.y), systematic(bias_z, scale, x.z)};
  };
  Vec sg{none, none, none}, sb = sg;
  if constexpr (kModel.bias_is_random || kModel.systematic_terms || kModel.axial) {
    sg = all_systematic(T(v.g_bias), T(v.g_bias), v.g_scale, u);
    sb = all_systematic(T(v.b_bias), T(v.bz_bias), v.b_scale, h);
  }
  Vec vg{ng, ng, ng}, vb{nb, nb, nb};
  if constexpr (kModel.bias_is_random) {
    vg = vg + sg;
    vb = vb + sb;
  }
  if constexpr (kModel.axial) vb.z = none;

  const Sums<T> own = sums(vg, vb, d);
  [[maybe_unused]] Sums<T> common{};
  if constexpr (kModel.systematic_terms) common = sums(sg, sb, d);
  const double count = kModel.shared ? v.stations : 1;
  Matrix3<T> of_all = own.covariance;
  if constexpr (kModel.systematic_terms)
    for (std::size_t k = 0; k < of_all.size(); ++k) of_all[k] = fma(T(count), common.covariance[k], of_all[k]);
  if constexpr (kModel.references) {
    of_all[0] = fma(T(count), T(v.gravity), of_all[0]);
    of_all[2] = fma(T(count), T(v.total_field), of_all[2]);
    of_all[5] = fma(T(count), T(v.dip), of_all[5]);
  }
  Matrix3<T> w_sum = inverse(of_all), w = w_sum;
  if constexpr (kModel.shared) {
    if (count > 1) {  // the same for all lanes
      const Matrix3<T> w0 = inverse(own.covariance);
      for (std::size_t k = 0; k < w.size(); ++k) w[k] = fma(T(count - 1), w0[k], w_sum[k]) * T(1 / count);
    }
  }

  // Without bz the conditions lose the direction in which its unknown error moves them.
  [[maybe_unused]] Vec wz{none, none, none};
  [[maybe_unused]] T scale_z = none, lost_turn = none;
  const T per_si = one / abs(s.si), per_cd = one / s.cd;  // abs: -0 must not turn the sign of an infinity
  if constexpr (kModel.axial) {
    wz = times(w, Vec{none, h.z, m.z});
    const T zwz = fma(h.z, wz.y, m.z * wz.z);
    // bz does not enter the conditions (horizontal, east or west), and was the only information on the azimuth
    const auto azimuth_is_lost = zwz * (nb + sb.z) < T(kLeastRedundancy);
    scale_z = select(azimuth_is_lost, none, one / zwz);
    lost_turn = select(azimuth_is_lost, e.z * per_cd * infinity, none);
    const Vec minus{-wz.x * scale_z, -wz.y * scale_z, -wz.z * scale_z};
    w = {fma(minus.x, wz.x, w[0]), fma(minus.y, wz.x, w[1]), fma(minus.y, wz.y, w[2]),
         fma(minus.z, wz.x, w[3]), fma(minus.z, wz.y, w[4]), fma(minus.z, wz.z, w[5])};
    w_sum = w;
  }

  // f = W a, a: products of the variances with an effect on the attitude, by kind of condition. Systematic terms act at
  // all stations: a reading's through W_N, those of a reference once a station.
  const auto subtracted = [&](const Vec& a, const Vec& a_common) -> Subtracted<T> {
    if constexpr (kModel.systematic_terms)
      return {times(w, a) + times(w_sum, a_common), times(w_sum, a + scale(T(count), a_common))};
    else if constexpr (kModel.shared)
      return {times(w, a), times(w_sum, a)};
    const Vec f = times(w, a);
    return {f, f};
  };
  const auto subtracted_xz = [&](const T& x, const T& z, const T& common_x, const T& common_z) -> Subtracted<T> {
    if constexpr (kModel.systematic_terms)
      return {times_xz(w, x, z) + times_xz(w_sum, common_x, common_z),
              times_xz(w_sum, fma(T(count), common_x, x), fma(T(count), common_z, z))};
    else if constexpr (kModel.shared)
      return {times_xz(w, x, z), times_xz(w_sum, x, z)};
    const Vec f = times_xz(w, x, z);
    return {f, f};
  };
  // The tool turns about the vertical by (e.dh - sinD e.du)/cosD
  const T turn_g = s.sd * per_cd;
  const auto turned_by = [&](const Sums<T>& x) {
    return Vec{turn_g * x.east_u, -x.east_h * per_cd, fms(turn_g, x.east_n, x.east_m * per_cd)};
  };
  const Subtracted<T> inclination_f =
      subtracted_xz(own.inclination_u, own.inclination_n, common.inclination_u, common.inclination_n);
  const Subtracted<T> across_f = subtracted_xz(own.across_u, own.across_n, common.across_u, common.across_n);
  Vec turned_in_common{};
  if constexpr (kModel.systematic_terms) turned_in_common = turned_by(common);
  Subtracted<T> turn_f = subtracted(turned_by(own), turned_in_common);
  [[maybe_unused]] Subtracted<T>
      for_bz{};  // what the others leave for bz, whose estimate takes the place of its reading
  if constexpr (kModel.axial) {
    const T per_z = -e.z * per_cd * scale_z;
    for_bz = {scale(per_z, wz), scale(per_z, wz)};
    turn_f = plus(turn_f, per_z, {wz, wz});
  }
  // Leaning to the right of the hole makes toolface and azimuth move against each other. Infinite, or not a number, in
  // a vertical hole.
  const Subtracted<T> toolface_f{scale(per_si, across_f.reading), scale(per_si, across_f.reference)};
  const Subtracted<T> azimuth_f = plus(turn_f, -s.ci, toolface_f);
  const T lean_x = d.tau.x * per_si, lean_y = d.tau.y * per_si;

  const std::array<T, 6> first{u.x, u.y, u.z, h.x, h.y, h.z};      // entries of a reading's column: gravity or field,
  const std::array<T, 6> dip_entry{n.x, n.y, n.z, m.x, m.y, m.z};  // and dip
  const std::array<T, 9> variance{vg.x, vg.y, vg.z, vb.x, vb.y, vb.z, T(v.gravity), T(v.total_field), T(v.dip)};
  const std::array<T, 3> own_inclination{d.iota.x, d.iota.y, d.iota.z}, own_across{d.tau.x, d.tau.y, none},
      own_toolface{lean_x, lean_y, none};
  const std::array<T, 6> own_turn{turn_g * e.x,  turn_g * e.y,  turn_g * e.z,
                                  -e.x * per_cd, -e.y * per_cd, -e.z * per_cd};
  // Columns have zeros: gravity and total field of the readings, all but one entry of the references
  const auto less = [&](const T& from, const Subtracted<T>& f, std::size_t i) {  // from - f'c
    if (i >= 6) return from + (i == 6 ? f.reference.x : i == 7 ? f.reference.y : f.reference.z);
    return fma(-(i < 3 ? f.reading.x : f.reading.y), first[i], fma(-f.reading.z, dip_entry[i], from));
  };
  std::array<Subtracted<T>, 3> references_f{};
  if (kModel.references && reference_effects) {
    const std::array<T, 3> prior{T(v.gravity), T(v.total_field), T(v.dip)};
    const std::array<Vec, 3> rows{Vec{w_sum[0], w_sum[1], w_sum[3]}, Vec{w_sum[1], w_sum[2], w_sum[4]},
                                  Vec{w_sum[3], w_sum[4], w_sum[5]}};
    for (std::size_t k = 0; k < 3; ++k)
      references_f[k] = {scale(-prior[k], rows[k]), scale(-prior[k] * T(count), rows[k])};
  }
  const T twice_gravity = w[3] + w[3], twice_field = w[4] + w[4];
  const auto not_vertical = T(kLeastSine) <= abs(s.si);

#pragma GCC unroll 9
  for (std::size_t i = 0; i < 9; ++i) {
    if ((wanted >> i & 1) == 0) continue;
    const bool reference = i >= 6;
    const T information =
        reference ? w_sum[packed(i - 6, i - 6)] * T(count)
                  : fma(first[i], fma(first[i], w[i < 3 ? 0 : 2], (i < 3 ? twice_gravity : twice_field) * dip_entry[i]),
                        dip_entry[i] * (dip_entry[i] * w[5]));
    ObservationReliability<T> r;
    r.redundancy = information * variance[i];
    const auto controlled = T(kLeastRedundancy) <= r.redundancy;
    const auto plain_here = controlled & not_vertical;
    // Nearly all points are plain. A point that is not sends all lanes the longer way, which gives plain points the
    // same bits.
    // Roots and quotients wait for the same divider, longer than products for theirs: every other root is made of
    // these.
    const bool by_products = kRootsByProducts<T> && i % 2 == 0;
    const bool plain = by_products ? all(plain_here & (T(kLeastRoot) <= information) & (information <= T(kLargestRoot)))
                                   : all(plain_here);
    r.detectable = plain ? T(v.lambda0) / (by_products ? sqrt_by_products(information) : sqrt(information))
                         : select(controlled, T(v.lambda0) / sqrt(select(controlled, information, one)), infinity);
    T turn_alone = reference ? none : own_turn[i];
    if constexpr (kModel.axial) turn_alone = turn_alone + lost_turn;
    const T inclination_alone = i < 3 ? own_inclination[i] : none, toolface_alone = i < 3 ? own_toolface[i] : none;
    const T azimuth_alone = i < 3 ? fma(-s.ci, toolface_alone, turn_alone) : turn_alone;
    const T angle = r.detectable * angle_unit;
    r.inclination = less(inclination_alone, inclination_f, i) * angle;
    r.toolface = less(toolface_alone, toolface_f, i) * angle;
    r.azimuth = less(azimuth_alone, azimuth_f, i) * angle;
    if (!plain) {
      // An error that no residual shows goes into the estimates in full.
      const auto of = [&](const T& alone, const Subtracted<T>& f) {
        return select(controlled, less(alone, f, i), alone);
      };
      const auto sized = [&](const T& x) { return times_maybe_infinite(x, angle, variance[i]); };
      const T across = of(i < 3 ? own_across[i] : none, across_f);
      const T toolface = times_maybe_infinite(across, per_si, variance[i]);
      // The inclination of a vertical hole changes by its tilt, to whichever side
      const T along = of(inclination_alone, inclination_f), tilt = sqrt(fma(along, along, across * across));
      const T inclination = select(not_vertical, along, select(s.ci < none, -tilt, tilt));
      T turn = turn_alone;
      if constexpr (kModel.axial) turn = less(turn_alone, for_bz, i);
      turn = select(controlled, less(turn_alone, turn_f, i), turn);
      r.redundancy = select(controlled, r.redundancy, none);
      r.inclination = select(plain_here, r.inclination, sized(inclination));
      r.toolface = select(plain_here, r.toolface, sized(toolface));
      r.azimuth = select(plain_here, r.azimuth, sized(fma(-s.ci, toolface, turn)));
    }
    r.gravity = r.total_field = r.dip = none;
    if (kModel.references && reference_effects) {
      const auto effect = [&](std::size_t k) {
        const T alone = i == 6 + k ? one : none, x = less(alone, references_f[k], i);
        return plain ? x * r.detectable : times_maybe_infinite(select(controlled, x, alone), r.detectable, variance[i]);
      };
      r.gravity = effect(0);
      r.total_field = effect(1);
      r.dip = effect(2);
    }
    use(i, r);
  }
}

}  // namespace surveymc::reliability
