#pragma once
#include "survey/minimum_curvature.h"

namespace surveymc {

/// How legs between stations are drawn.
enum class PositionMethod { minimum_curvature, balanced_tangential };

template <class T>
Vec3<T> leg(PositionMethod method, const T& dmd, const Vec3<T>& from, const Vec3<T>& to) {
  return method == PositionMethod::minimum_curvature ? minimum_curvature_leg(dmd, from, to)
                                                     : balanced_tangential_leg(dmd, from, to);
}

inline LegDerivatives leg_derivatives(PositionMethod method, double dmd, const Vec3<double>& from,
                                      const Vec3<double>& to) {
  if (method == PositionMethod::minimum_curvature) return minimum_curvature_derivatives(dmd, from, to);
  const Eigen::Matrix3d half = 0.5 * dmd * Eigen::Matrix3d::Identity();
  return {half, half};
}

}  // namespace surveymc
