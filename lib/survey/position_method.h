#pragma once
#include "survey/minimum_curvature.h"

namespace surveymc::survey {

/// How legs between stations are drawn.
enum class PositionMethod { minimum_curvature, balanced_tangential };

template <class T>
Vec3<T> interval_displacement(PositionMethod method, const T& dmd, const Vec3<T>& from, const Vec3<T>& to) {
  return method == PositionMethod::minimum_curvature ? minimum_curvature_interval(dmd, from, to)
                                                     : balanced_tangential_interval(dmd, from, to);
}

inline IntervalDerivatives interval_derivatives(PositionMethod method, double dmd, const Vec3<double>& from,
                                                const Vec3<double>& to) {
  if (method == PositionMethod::minimum_curvature) return minimum_curvature_derivatives(dmd, from, to);
  const Eigen::Matrix3d half = 0.5 * dmd * Eigen::Matrix3d::Identity();
  return {half, half};
}

}  // namespace surveymc::survey
