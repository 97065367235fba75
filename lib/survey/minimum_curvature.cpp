#include "survey/minimum_curvature.h"

#include "survey/position_method.h"

namespace surveymc::survey {

double ratio_factor_slope(double s) {
  // Series RF = 1 + s/3 + 11/45 s^2 + 191/945 s^3 + ...: below 1e-4 its next term is under 1e-12 of the slope.
  if (s < 1e-4) return 1.0 / 3 + s * (22.0 / 45 + s * (191.0 / 315));
  const double h = std::asin(std::sqrt(s)), sc = std::sqrt(s * (1 - s));  // h = beta/2, sc = sin h cos h
  return (h - sc) / (2 * h * h * (1 - s) * sc);
}

IntervalDerivatives minimum_curvature_derivatives(double dmd, const Vec3<double>& from, const Vec3<double>& to) {
  const Eigen::Vector3d t1 = to_eigen(from), t2 = to_eigen(to), chord = t2 - t1, sum = t1 + t2;
  const double s = chord.squaredNorm() / 4;
  // ds/dt2 = chord / 2 = -ds/dt1
  const Eigen::Matrix3d turn = ratio_factor_slope(s) * 0.5 * sum * chord.transpose();
  const Eigen::Matrix3d straight = ratio_factor(s) * Eigen::Matrix3d::Identity();
  return {0.5 * dmd * (straight - turn), 0.5 * dmd * (straight + turn)};
}

std::vector<Eigen::Vector3d> minimum_curvature_positions(const std::vector<double>& md,
                                                         const std::vector<Vec3<double>>& tangents) {
  std::vector<Eigen::Vector3d> p(md.size(), Eigen::Vector3d::Zero());
  for (std::size_t k = 1; k < md.size(); ++k)
    p[k] = p[k - 1] + to_eigen(minimum_curvature_interval(md[k] - md[k - 1], tangents[k - 1], tangents[k]));
  return p;
}
std::vector<Eigen::Vector3d> minimum_curvature_positions(const Survey& survey) {
  return minimum_curvature_positions(survey.md(), true_tangents(survey));
}

std::vector<double> true_vertical_depths(const Survey& survey) {
  std::vector<double> tvd;
  for (const Eigen::Vector3d& p : minimum_curvature_positions(survey))
    tvd.push_back(survey.stations.front().md + p.z());
  return tvd;
}

std::vector<Eigen::Matrix3d> final_position_by_tangent(const std::vector<double>& md,
                                                       const std::vector<Vec3<double>>& tangents) {
  std::vector<Eigen::Matrix3d> d(md.size(), Eigen::Matrix3d::Zero());
  walk_intervals(PositionMethod::minimum_curvature, md, tangents,
                 [&](std::size_t k, const IntervalDerivatives& interval, const Eigen::Matrix3d&) {
                   d[k - 1] += interval.by_from;
                   d[k] += interval.by_to;
                 });
  return d;
}

}  // namespace surveymc::survey
