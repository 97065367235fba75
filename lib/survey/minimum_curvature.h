#pragma once
/// From directions along the hole to positions: minimum curvature and balanced tangential, with derivatives.
///
/// An interval of length dD between unit tangents t1 and t2 (N frame) that enclose the dogleg beta displaces by
///   minimum curvature   dr = dD/2 RF (t1 + t2),  RF = tan(beta/2) / (beta/2)    (thesis eq 18; RF = 1 at beta = 0)
///   balanced tangential dr = dD/2 (t1 + t2)
/// RF is a smooth function of s = sin^2(beta/2) = |t2 - t1|^2 / 4: no angle is computed and nothing is 0/0.
#include <vector>

#include <Eigen/Core>

#include "simd/math.h"
#include "survey/survey.h"

namespace surveymc::survey {

using namespace simd;

/// RF(s) for s in [0, 1); relative error below 1e-15 for s < 1/4, growing like 1e-16 / (1 - s) towards a reversal.
/// T: double, Lanes or Dual.
template <class T>
T ratio_factor(const T& s) {
  const T small = asin_ratio(select(s < T(0.25), s, T(0.25)));
  T half_dogleg_per_sine = small;
  if (any(s > T(0.25))) {
    // asin x = pi/2 - 2 asin(sqrt((1 - x)/2)) beyond x = 1/2 (doglegs beyond 60 deg)
    const T x = sqrt(select(s > T(0.25), s, T(0.25)));
    const T z = (T(1.0) - x) * T(0.5);
    const T large = (T(1.5707963267948966) - T(2.0) * sqrt(z) * asin_ratio(z)) / x;
    half_dogleg_per_sine = select(s > T(0.25), large, small);
  }
  return T(1.0) / (sqrt(T(1.0) - s) * half_dogleg_per_sine);
}

/// Displacement of one interval in the frame of the tangents, metres.
template <class T>
Vec3<T> minimum_curvature_interval(const T& dmd, const Vec3<T>& from, const Vec3<T>& to) {
  const Vec3<T> chord = to - from;
  const T s = dot(chord, chord) * T(0.25);
  return scale(T(0.5) * dmd * ratio_factor(s), from + to);
}

template <class T>
Vec3<T> balanced_tangential_interval(const T& dmd, const Vec3<T>& from, const Vec3<T>& to) {
  return scale(T(0.5) * dmd, from + to);
}

/// dRF/ds, relative error below 1e-10.
double ratio_factor_slope(double s);

/// Derivatives of one interval's displacement by its two tangents (metres per unit of a tangent component).
struct IntervalDerivatives {
  Eigen::Matrix3d by_from, by_to;
};
IntervalDerivatives minimum_curvature_derivatives(double dmd, const Vec3<double>& from, const Vec3<double>& to);

/// Positions of all stations relative to the first (N, E, V in metres), tangents in N, true north.
std::vector<Eigen::Vector3d> minimum_curvature_positions(const std::vector<double>& md,
                                                         const std::vector<Vec3<double>>& tangents);
std::vector<Eigen::Vector3d> minimum_curvature_positions(const Survey& survey);

/// True vertical depth of all stations by minimum curvature, m; that of the first is taken to be its measured depth.
std::vector<double> true_vertical_depths(const Survey& survey);

/// Derivative of the last position by the tangent of every station: 3x3 each.
std::vector<Eigen::Matrix3d> final_position_by_tangent(const std::vector<double>& md,
                                                       const std::vector<Vec3<double>>& tangents);

}  // namespace surveymc::survey
