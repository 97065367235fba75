#pragma once
/// A well by the angles of its stations, as the literature has it: what the library, which knows tangents alone, is
/// compared with.
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "survey/position_method.h"
#include "survey/survey.h"

namespace surveymc::test {

/// Derivatives of the tangent (sinI cosA, sinI sinA, cosI) by inclination and azimuth.
inline Eigen::Vector3d tangent_by_inclination(double inclination, double azimuth) {
  const double ci = std::cos(inclination);
  return {ci * std::cos(azimuth), ci * std::sin(azimuth), -std::sin(inclination)};
}
inline Eigen::Vector3d tangent_by_azimuth(double inclination, double azimuth) {
  const double si = std::sin(inclination);
  return {-si * std::sin(azimuth), si * std::cos(azimuth), 0};
}

/// Positions of all stations relative to the first (N, E, V in metres).
inline std::vector<Eigen::Vector3d> balanced_tangential_positions(const survey::Survey& survey) {
  const std::vector<survey::Vec3<double>> t = survey::true_tangents(survey);
  std::vector<Eigen::Vector3d> p(t.size(), Eigen::Vector3d::Zero());
  for (std::size_t k = 1; k < t.size(); ++k)
    p[k] = p[k - 1] + to_eigen(survey::balanced_tangential_interval(survey.stations[k].md - survey.stations[k - 1].md,
                                                                    t[k - 1], t[k]));
  return p;
}

}  // namespace surveymc::test
