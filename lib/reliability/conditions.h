#pragma once
/// The three conditions among the observations of a station, and their derivatives: the condition form of the paper's
/// models (eqs 39-44). It has no angles, so it is regular in a vertical hole.
///
///   f = ( |g| - G,  |b| - B,  asin(g.b / (|g||b|)) - Theta )
#include <Eigen/Core>

#include "reliability/observations.h"

namespace surveymc::reliability {

using Misclosures = Eigen::Vector3d;                          ///< m/s2, nT, rad
using StationJacobian = Eigen::Matrix<double, 3, kReadings>;  ///< of the misclosures by the six readings

struct Conditions {
  Misclosures values;  ///< with references of zero: |g|, |b|, dip
  StationJacobian jacobian;
};

/// At any readings (m/s2, nT), consistent or not. g and b must not vanish nor be parallel.
///   d|g|/dg = u,  d|b|/db = h,  ddip/dg = (h - sinD u)/(|g| cosD),  ddip/db = (u - sinD h)/(|b| cosD)
inline Conditions station_conditions(const double* readings) {
  const Eigen::Vector3d g(readings[0], readings[1], readings[2]), b(readings[3], readings[4], readings[5]);
  const double gravity = g.norm(), total = b.norm();
  const Eigen::Vector3d u = g / gravity, h = b / total;
  const double sine = u.dot(h);
  const Eigen::Vector3d across(u.y() * h.z() - u.z() * h.y(), u.z() * h.x() - u.x() * h.z(),
                               u.x() * h.y() - u.y() * h.x());
  const double cosine = across.norm();
  Conditions c;
  c.values << gravity, total, std::atan2(sine, cosine);
  c.jacobian.setZero();
  c.jacobian.row(0).head<3>() = u.transpose();
  c.jacobian.row(1).tail<3>() = h.transpose();
  c.jacobian.row(2).head<3>() = (h - sine * u).transpose() / (gravity * cosine);
  c.jacobian.row(2).tail<3>() = (u - sine * h).transpose() / (total * cosine);
  return c;
}

}  // namespace surveymc::reliability
