#include "propagate/tangent_propagation.h"

#include <cassert>

namespace surveymc::propagate {

using Eigen::Matrix3d;

namespace {

/// (D Y)(D Y)'
Matrix3d square(const Matrix3d& d, const Eigen::Matrix3Xd& y) {
  const Eigen::Matrix3Xd x = d * y;
  return x * x.transpose();
}

}  // namespace

std::vector<Matrix3d> propagate_tangent_errors(const std::vector<double>& md,
                                               const std::vector<survey::Vec3<double>>& tangents,
                                               const std::vector<TangentErrors>& errors,
                                               survey::PositionMethod method) {
  assert(md.size() == tangents.size() && md.size() == errors.size());
  std::vector<Matrix3d> covariances(md.size(), Matrix3d::Zero());
  if (md.empty()) return covariances;
  Eigen::Matrix3Xd constant = Eigen::Matrix3Xd::Zero(3, errors[0].constant.cols());
  Matrix3d independent = Matrix3d::Zero();  // of the stations passed, whose both intervals are known
  survey::walk_intervals(
      method, md, tangents, [&](std::size_t k, const survey::IntervalDerivatives& d, const Matrix3d& arriving) {
        constant += d.by_from * errors[k - 1].constant + d.by_to * errors[k].constant;
        independent += square(arriving + d.by_from, errors[k - 1].independent);
        covariances[k] = constant * constant.transpose() + independent + square(d.by_to, errors[k].independent);
      });
  return covariances;
}

}  // namespace surveymc::propagate
