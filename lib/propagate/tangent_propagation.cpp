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
  Matrix3d independent = Matrix3d::Zero();  // of the stations passed, whose both legs are known
  Matrix3d leg_before = Matrix3d::Zero();   // by the tangent of station k - 1, of the leg that ends there
  for (std::size_t k = 1; k < md.size(); ++k) {
    const survey::IntervalDerivatives d =
        survey::interval_derivatives(method, md[k] - md[k - 1], tangents[k - 1], tangents[k]);
    constant += d.by_from * errors[k - 1].constant + d.by_to * errors[k].constant;
    independent += square(leg_before + d.by_from, errors[k - 1].independent);
    covariances[k] = constant * constant.transpose() + independent + square(d.by_to, errors[k].independent);
    leg_before = d.by_to;
  }
  return covariances;
}

}  // namespace surveymc::propagate
