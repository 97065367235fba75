#pragma once
#include <vector>

#include "survey/minimum_curvature.h"

namespace surveymc::survey {

/// Path between two stations.
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

/// Goes from interval to interval: visit(k, d, arriving) for every station k after the first. d: displacement of the
/// interval from k - 1 to k by the tangents of both; arriving: of the interval before by the tangent of k - 1, zero for
/// the first. So arriving + d.by_from is the derivative of all positions from k on by the tangent of k - 1, and
/// d.by_to that of position k by its own tangent.
template <class Visit>
void walk_intervals(PositionMethod method, const std::vector<double>& md, const std::vector<Vec3<double>>& tangents,
                    Visit visit) {
  Eigen::Matrix3d arriving = Eigen::Matrix3d::Zero();
  for (std::size_t k = 1; k < md.size(); ++k) {
    const IntervalDerivatives d = interval_derivatives(method, md[k] - md[k - 1], tangents[k - 1], tangents[k]);
    visit(k, d, arriving);
    arriving = d.by_to;
  }
}

}  // namespace surveymc::survey
