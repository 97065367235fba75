#pragma once
/// One leg of a drawn well (well_errors.h), for any scalar: a trial, a lane of trials, or a dual number.
#include <utility>

#include "simd/math.h"
#include "survey/frames.h"
#include "survey/minimum_curvature.h"

namespace surveymc::propagate {

using namespace simd;

/// True attitude of a station.
struct StationAttitude {
  double sin_i = 0, cos_i = 1, sin_a = 0, cos_a = 1;
};

/// A leg of the true well. `doubled`: m, half of the first leg's length where it is doubled, else 0.
struct LegGeometry {
  StationAttitude from, to;
  double length = 0, doubled = 0;  ///< m
};

/// dD (m), dI, dA, tau (rad) of a station in a trial.
template <class T>
struct DrawnErrors {
  T depth, inclination, azimuth, tilt;
};

/// {sin x, cos x}, accurate to 1e-16. Errors are small: up to 1/8 rad (7 deg) a short Taylor series does. Each lane
/// chooses by its own value alone.
template <class T>
[[gnu::always_inline]] inline std::pair<T, T> sincos_of_error(const T& x) {
  if constexpr (requires { to_bits(x); }) {
    const T z = x * x;
    const T s = fma(z, fma(z, fma(z, T(1.0 / 362880), T(-1.0 / 5040)), T(1.0 / 120)), T(-1.0 / 6));
    const T c = fma(z, fma(z, fma(z, T(-1.0 / 3628800), T(1.0 / 40320)), T(-1.0 / 720)), T(1.0 / 24));
    const std::pair<T, T> small{fma(x * z, s, x), fma(z * z, c, fma(z, T(-0.5), T(1.0)))};
    const auto is_large = abs(x) > T(0.125);
    if (!any(is_large)) return small;
    const auto [sine, cosine] = sincos(x);
    return {select(is_large, sine, small.first), select(is_large, cosine, small.second)};
  } else {
    return sincos(x);
  }
}

/// survey::ratio_factor(s), by the series of tan(phi) / phi in s = sin^2(phi) up to doglegs of 16 deg, accurate to
/// 1e-16.
template <class T>
[[gnu::always_inline]] inline T ratio_factor_of_leg(const T& s) {
  constexpr double kSmall = 0.02;
  T r(0.11870);  // times 0.02^9: what stands behind it does not count
  for (const double c : {0.12576392683612658, 0.1342621420646112, 0.14475378746278217, 0.15816364705253594,
                         0.1761552028218695, 0.2021164021164021, 0.24444444444444444, 0.3333333333333333, 1.0})
    r = fma(s, r, T(c));
  const auto is_large = s > T(kSmall);
  if (!any(is_large)) return r;
  return select(is_large, survey::ratio_factor(s), r);
}

/// survey::minimum_curvature_interval with that ratio factor.
template <class T>
[[gnu::always_inline]] inline survey::Vec3<T> leg_displacement(const T& length, const survey::Vec3<T>& from,
                                                               const survey::Vec3<T>& to) {
  const survey::Vec3<T> chord = to - from;
  const T s = dot(chord, chord) * T(0.25);
  return scale(T(0.5) * length * ratio_factor_of_leg(s), from + to);
}

/// Which angles of a station have errors in any trial: the others need no sines.
struct DrawnAngles {
  bool inclination = true, azimuth = true, tilt = true;
};

/// Direction of the drawn hole: N, E, V. The same bits whether an error that is zero is left out by `has` or not.
template <class T>
[[gnu::always_inline]] inline survey::Vec3<T> drawn_tangent(const StationAttitude& at, const DrawnErrors<T>& e,
                                                            const DrawnAngles& has = {}) {
  std::pair<T, T> inclination{T(0.0), T(1.0)}, azimuth = inclination, tilt = inclination;
  if (has.inclination) inclination = sincos_of_error(e.inclination);
  if (has.azimuth) azimuth = sincos_of_error(e.azimuth);
  if (has.tilt) tilt = sincos_of_error(e.tilt);
  const auto& [s_i, c_i] = inclination;
  const auto& [s_a, c_a] = azimuth;
  const auto& [s_t, c_t] = tilt;
  const T sin_i = fma(T(at.sin_i), c_i, T(at.cos_i) * s_i), cos_i = fma(T(at.cos_i), c_i, T(-at.sin_i) * s_i);
  const T sin_a = fma(T(at.sin_a), c_a, T(at.cos_a) * s_a), cos_a = fma(T(at.cos_a), c_a, T(-at.sin_a) * s_a);
  const T along = c_t * sin_i;
  return {fma(along, cos_a, -(s_t * sin_a)), fma(along, sin_a, s_t * cos_a), c_t * cos_i};
}

/// Displacement from the beginning of an arc of `length` to the point at `share` of it. With beta the dogleg, it is
/// a t1 + b t2,  b = length (1 - cos(share beta)) / (beta sin beta),  a = length sin(share beta) / beta - b cos beta.
template <class T>
survey::Vec3<T> arc_point(const T& length, const survey::Vec3<T>& from, const survey::Vec3<T>& to, double share) {
  const survey::Vec3<T> chord = to - from;
  const T s = dot(chord, chord) * T(0.25);  // sin^2(beta / 2)
  const T cos_half = sqrt(T(1.0) - s);
  const T half_per_sine = T(1.0) / (cos_half * ratio_factor_of_leg(s));  // (beta / 2) / sin(beta / 2)
  // y = (share beta / 2)^2; its sine over it, and its cosine, are smooth in y.
  const T y = T(share * share) * s * half_per_sine * half_per_sine;
  T ratio = T(1.0) + y * (T(-1.66666666666666324348e-01) +
                          y * (T(8.33333333332248946124e-03) +
                               y * (T(-1.98412698298579493134e-04) +
                                    y * (T(2.75573137070700676789e-06) +
                                         y * (T(-2.50507602534068634195e-08) + y * T(1.58969099521155010221e-10))))));
  T cosine = T(1.0) - T(0.5) * y +
             y * y *
                 (T(4.16666666666666019037e-02) +
                  y * (T(-1.38888888888741095749e-03) +
                       y * (T(2.48015872894767294178e-05) +
                            y * (T(-2.75573143513906633035e-07) +
                                 y * (T(2.08757232129817482790e-09) + y * T(-1.13596475577881948265e-11))))));
  constexpr double kPolynomials = 0.6168502750680849;  // (pi / 4)^2
  if (any(y > T(kPolynomials))) {
    const T angle = sqrt(select(y > T(kPolynomials), y, T(kPolynomials)));
    const auto [sine, cosine_of] = sincos(angle);
    ratio = select(y > T(kPolynomials), sine / angle, ratio);
    cosine = select(y > T(kPolynomials), cosine_of, cosine);
  }
  const T b = T(0.5 * share * share) * ratio * ratio * half_per_sine / cos_half;
  const T a = T(share) * ratio * cosine - b * (T(1.0) - T(2.0) * s);
  const survey::Vec3<T> r{fma(a, from.x, b * to.x), fma(a, from.y, b * to.y), fma(a, from.z, b * to.z)};
  return scale(length, r);
}

/// Displacement from the beginning of a drawn leg to the point at `share` of it, without course displacements; m.
/// `from_t` and `to_t`: the drawn tangents.
template <class T>
[[gnu::always_inline]] inline survey::Vec3<T> drawn_leg_between(const LegGeometry& leg, const T& depth_from,
                                                                const T& depth_to, const survey::Vec3<T>& from_t,
                                                                const survey::Vec3<T>& to_t, double share) {
  const T length = T(leg.length) + (depth_to - depth_from);
  survey::Vec3<T> r = share == 1 ? leg_displacement(length, from_t, to_t) : arc_point(length, from_t, to_t, share);
  if (leg.doubled != 0) {
    const StationAttitude& at = leg.to;
    const survey::Vec3<T> truth{T(at.sin_i * at.cos_a), T(at.sin_i * at.sin_a), T(at.cos_i)};
    r = r + scale(T(share * leg.doubled), to_t - truth);
  }
  return r;
}

/// The same from the errors of both stations.
template <class T>
survey::Vec3<T> drawn_leg_point(const LegGeometry& leg, const DrawnErrors<T>& from, const DrawnErrors<T>& to,
                                double share) {
  return drawn_leg_between(leg, from.depth, to.depth, drawn_tangent(leg.from, from), drawn_tangent(leg.to, to), share);
}

}  // namespace surveymc::propagate
