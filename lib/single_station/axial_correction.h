#pragma once
/// The arithmetic of station_solution.h for any scalar type: double, Lanes or Dual.
///
/// With p = (cosI sin tau, cosI cos tau, sinI), r = (cos tau, -sin tau, 0), u = (-sinI sin tau, -sinI cos tau, cosI),
/// an orthonormal base, the readings are b = N p + E r + D u + (0, 0, Mz), where N = Bh cosA, E = Bh sinA, D = Bd.
/// Turned about the axis of the tool they are
///   high  = bx sin tau + by cos tau = cosI N - sinI D         variance s_xy^2
///   right = bx cos tau - by sin tau = E                       s_xy^2
///   bz                              = sinI N + cosI D + Mz    s_z^2
/// The errors of x and y are alike, so E is independent of the other unknowns. Bd_ref and Mz = 0 add one condition,
///   w = Bd_ref - (cosI bz - sinI high) = 0,   variance V = sin^2 I s_xy^2 + cos^2 I (s_z^2 + s_M^2) + s_Bd^2
/// and weighted least squares moves N, D, Mz by their gains times w (condition adjustment: the same minimum as with
/// the design matrix of slide 3). s_Bd = 0 with s_M growing is `simple`; s_M = 0 with s_Bd growing is `basic`.
#include "estimate/circle_pull.h"
#include "single_station/station_solution.h"

namespace surveymc::single_station {

using namespace simd;

/// Attitude in the form that the kernels use, and |g|.
template <class T>
struct ToolAxes {
  T si, ci, st, ct, gravity;
  T found;  ///< 1, or 0 where there is no gravity
};

template <class T>
ToolAxes<T> tool_axes(const T& lean, const T& z, const T& st, const T& ct, const T& found) {
  const T total2 = fma(lean, lean, z * z);
  const auto there = T(0.0) < total2;
  const T total = sqrt(select(there, total2, T(1.0))), per_total = T(1.0) / total;
  return {lean * per_total, z * per_total, st, ct, total, select(there, found, T(0.0))};
}

/// Inclination and toolface from the accelerometers; toolface 0 where it is undefined. With `optimise`, |g| is pulled
/// to its reference (slide 4): the toolface stays, because the errors of x and y are alike, and so does the inclination
/// if z has the same error.
template <class T>
ToolAxes<T> axes_from_accelerometers(const survey::Vec3<T>& g, bool optimise, const T& reference,
                                     const StationSigmas& s) {
  const T lean2 = fma(g.x, g.x, g.y * g.y);
  const auto leans = T(0.0) < lean2;
  const T length = sqrt(select(leans, lean2, T(1.0)));
  const T lean = select(leans, length, T(0.0));
  const T st = select(leans, -g.x / length, T(0.0)), ct = select(leans, -g.y / length, T(1.0));
  if (!optimise) return tool_axes(lean, g.z, st, ct, T(1.0));
  const estimate::CirclePoint<T> p =
      estimate::pull_to_circle(lean, g.z, T(s.accelerometer_xy * s.accelerometer_xy),
                               T(s.accelerometer_z * s.accelerometer_z), reference, T(s.gravity * s.gravity));
  return tool_axes(p.x, p.y, st, ct, p.found);
}

/// Gains of N, D and Mz per unit of the misclosure w, and the variance V of w.
template <class T>
struct ConditionGains {
  T north, vertical, axial, variance;
  T found;  ///< 0 where cos I = 0 leaves `simple` without a solution
};

inline constexpr double kLeastCosine = 1e-6;  ///< |cos I| below which `simple` fails: 1 nT of Bd makes 1e6 nT of Bh

template <class T>
ConditionGains<T> condition_gains(const ToolAxes<T>& at, const StationSigmas& s, StationMethod method) {
  const bool with_axial = method == StationMethod::extended || method == StationMethod::extended_bh;
  const T a(s.magnetometer_xy * s.magnetometer_xy), m(with_axial ? s.axial * s.axial : 0.0);
  const T c(s.magnetometer_z * s.magnetometer_z + (with_axial ? s.axial * s.axial : 0.0));
  const T readings = fma(at.si * at.si, a, at.ci * at.ci * c);  // variance of the vertical field of the readings
  const T variance = readings + T(s.vertical * s.vertical);
  const T one(1.0), none(0.0);
  if (method == StationMethod::basic) return {none, none, none, variance, one};
  if (method == StationMethod::simple) {
    const auto solvable = T(kLeastCosine * kLeastCosine) < at.ci * at.ci;
    const T per_ci = one / select(solvable, at.ci, one);
    return {at.si * per_ci, one, -per_ci, variance, select(solvable, one, none)};
  }
  const T per_variance = one / variance;
  return {at.si * at.ci * (c - a) * per_variance, readings * per_variance, -(at.ci * m) * per_variance, variance, one};
}

/// Variances and covariances of N, E, D and the error of Mz before Bh is observed.
template <class T>
struct NorthCovariance {
  T north, east, vertical_north, axial_north;
};

template <class T>
NorthCovariance<T> north_covariance(const ToolAxes<T>& at, const ConditionGains<T>& k, const StationSigmas& s,
                                    StationMethod method) {
  const T a(s.magnetometer_xy * s.magnetometer_xy), b(s.vertical * s.vertical);
  const T m(method == StationMethod::extended_bh ? s.axial * s.axial : 0.0);
  const T c = T(s.magnetometer_z * s.magnetometer_z) + m;
  const T n_high = fma(k.north, at.si, at.ci), n_z = fma(-k.north, at.ci, at.si);
  const T d_high = at.si * (k.vertical - T(1.0)), d_z = at.ci * (T(1.0) - k.vertical);
  const T m_high = k.axial * at.si, m_z = -(k.axial * at.ci);
  return {fma(n_high * n_high, a, fma(n_z * n_z, c, k.north * k.north * b)), a,
          fma(d_high * n_high, a, fma(d_z * n_z, c, k.vertical * k.north * b)),
          fma(m_high * n_high, a, fma(m_z * n_z, c, k.axial * k.north * b)) - n_z * m};
}

/// N, E, D, Mz (nT).
template <class T>
struct FieldSolution {
  T north, east, vertical, axial, misclosure, cost;
  T found;  ///< 1, or 0 where the method gives no answer
};

/// The field at a given attitude. `horizontal` and `vertical`: the references Bh and Bd, nT.
template <class T>
FieldSolution<T> solve_field(const ToolAxes<T>& at, const survey::Vec3<T>& b, const T& horizontal, const T& vertical,
                             const StationSigmas& s, StationMethod method) {
  const T high = fma(b.x, at.st, b.y * at.ct), right = fma(b.x, at.ct, -(b.y * at.st));
  const ConditionGains<T> k = condition_gains(at, s, method);
  const T d = fma(at.ci, b.z, -(at.si * high)), w = vertical - d;
  FieldSolution<T> x{fma(at.ci, high, fma(at.si, b.z, k.north * w)),
                     right,
                     fma(k.vertical, w, d),
                     k.axial * w,
                     w,
                     T(0.0),
                     at.found * k.found};
  x.found = select(T(0.0) < fma(x.north, x.north, x.east * x.east), x.found, T(0.0));
  if (method == StationMethod::basic || method == StationMethod::simple) return x;  // no redundancy
  x.cost = w / k.variance * w;
  if (method == StationMethod::extended) return x;
  const NorthCovariance<T> p = north_covariance(at, k, s, method);
  const estimate::CirclePoint<T> c =
      estimate::pull_to_circle(x.north, x.east, p.north, p.east, horizontal, T(s.horizontal * s.horizontal));
  const T moved = (c.x - x.north) / p.north;
  x.north = c.x;
  x.east = c.y;
  x.vertical = fma(p.vertical_north, moved, x.vertical);
  x.axial = fma(p.axial_north, moved, x.axial);
  x.cost = x.cost + c.cost;
  x.found = x.found * c.found;
  return x;
}

}  // namespace surveymc::single_station
