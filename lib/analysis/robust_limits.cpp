#include "analysis/robust_limits.h"

#include <algorithm>
#include <cmath>

#include "multistation/robust.h"
#include "stats/linear_algebra.h"

namespace surveymc::analysis {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

Matrix3d sizes_of(const multistation::ReferenceErrors& e) { return Vector3d(e.gravity, e.total, e.dip).asDiagonal(); }

}  // namespace

RobustLimits worse_of(const RobustLimits& a, const RobustLimits& b) {
  return {std::max(a.shared, b.shared), std::max(a.uneven, b.uneven)};
}

RobustLimits robust_limits(const ResidualErrors& errors, const multistation::FitOptions& o,
                           const std::vector<multistation::StationModel>& models,
                           const multistation::FitSensitivity& sensitive) {
  const multistation::FitPlan plan = multistation::fit_plan(o);
  const Matrix3d by_reference = multistation::reference_derivatives(plan), run = sizes_of(errors.run),
                 station = sizes_of(errors.station);
  const Eigen::Index components = multistation::robust_components(plan);
  const int p = o.parameters.size();
  const Eigen::Map<const VectorXd> tool(errors.tool.data(), multistation::kParameters),
      tool_sd(errors.tool_sd.data(), multistation::kParameters);
  MatrixXd of_reference = MatrixXd::Zero(sensitive.by_truth.rows(), 3);
  for (const auto& e : sensitive.by_reference) of_reference += e;
  double shared = 0;
  Matrix3d own = Matrix3d::Zero();
  for (const multistation::StationModel& m : models) {
    const Matrix3d read = m.by_reference * by_reference;
    MatrixXd by_unknown(3, of_reference.rows());
    for (int i = 0; i < p; ++i) by_unknown.col(i) = m.by_parameter.col(o.parameters.index(i));
    if (o.estimates_reference) by_unknown.rightCols<3>() = read;
    MatrixXd of_tool = by_unknown * sensitive.by_truth;
    for (int i = 0; i < multistation::kParameters; ++i)
      if (!o.parameters.contains(i)) of_tool.col(i) -= m.by_parameter.col(i);
    const auto size = [components](const MatrixXd& x) { return x.bottomRows(components).squaredNorm(); };
    shared +=
        size(of_tool * tool) + size(of_tool * tool_sd.asDiagonal()) + size((by_unknown * of_reference + read) * run);
    const auto add = [&own](const Matrix3d& x) { own += x * x.transpose(); };
    add(errors.accelerometer * m.by_gravity);
    add(errors.magnetometer * m.by_magnetic);
    add(read * station);
  }
  RobustLimits limits;
  limits.shared = std::sqrt(shared / own.diagonal().tail(components).sum());
  const Eigen::Index noisy = multistation::noisy_components(plan);
  const VectorXd squares = stats::symmetric_eigenvalues(own.bottomRightCorner(noisy, noisy));
  if (squares[noisy - 1] > 0) limits.uneven = std::sqrt(squares[noisy - 1] / std::max(squares[0], 0.0));
  return limits;
}

}  // namespace surveymc::analysis
