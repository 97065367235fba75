#include "monitoring/survey_drift.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace surveymc::monitoring {

Eigen::Vector3d survey_channels(const Eigen::Vector3d& g, const Eigen::Vector3d& b) {
  // atan2 of the parts along and across g keeps its digits at dips near 90 deg, where asin loses them.
  return {g.norm(), b.norm(), std::atan2(g.dot(b), g.cross(b).norm())};
}

ChannelJacobian survey_channel_jacobian(const Eigen::Vector3d& g, const Eigen::Vector3d& b) {
  const Eigen::Vector3d u = g.normalized(), v = b.normalized();
  const double sin_dip = u.dot(v), cos_dip = u.cross(v).norm();
  ChannelJacobian h = ChannelJacobian::Zero();
  h.block<1, 3>(0, 0) = u.transpose();
  h.block<1, 3>(1, 3) = v.transpose();
  h.block<1, 3>(2, 0) = (v - sin_dip * u).transpose() / (cos_dip * g.norm());
  h.block<1, 3>(2, 3) = (u - sin_dip * v).transpose() / (cos_dip * b.norm());
  return h;
}

double BiasFilter::update(const Eigen::Vector3d& y, const ChannelJacobian& h, const Eigen::Matrix3d& r) {
  Matrix6 predicted = covariance_;
  predicted.diagonal() += process_;
  // Channels differ by powers of ten (m/s2, nT, rad): the solve is on the correlation scale.
  const Eigen::Matrix3d s = h * predicted * h.transpose() + r;
  const Eigen::Vector3d scale = s.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d scaled = scale.asDiagonal() * s * scale.asDiagonal();
  const Eigen::Matrix<double, 3, 6> left = scale.asDiagonal() * h * predicted;
  // The inverse of its triangular factor, column by column: Eigen unrolls what has one column.
  const Eigen::LLT<Eigen::Matrix3d> factor(scaled);
  Eigen::Matrix3d w;
  for (Eigen::Index j = 0; j < 3; ++j) w.col(j) = factor.matrixL().solve(Eigen::Vector3d(Eigen::Vector3d::Unit(j)));
  const Eigen::Matrix<double, 3, 6> solved = w.transpose() * (w * left);
  const Eigen::Matrix<double, 6, 3> gain = solved.transpose() * scale.asDiagonal();
  const Eigen::Vector3d innovation = y - h * bias_;
  bias_ += gain * innovation;
  const Matrix6 rest = Matrix6::Identity() - gain * h;
  covariance_ = rest * predicted * rest.transpose() + gain * r * gain.transpose();
  const Eigen::Vector3d v = scale.cwiseProduct(innovation);
  return (w * v).squaredNorm();
}

double normalised_error(const Vector6& error, const Matrix6& covariance) {
  // m/s2 and nT: the solve is on the correlation scale here, too.
  const Vector6 scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Vector6 e = scale.cwiseProduct(error);
  const Matrix6 scaled = scale.asDiagonal() * covariance * scale.asDiagonal();
  return scaled.llt().matrixL().solve(e).squaredNorm();
}

}  // namespace surveymc::monitoring
