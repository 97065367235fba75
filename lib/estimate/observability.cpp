#include "estimate/observability.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/ranges.h>

#include "base/units.h"
#include "stats/linear_algebra.h"

namespace surveymc::estimate {

Observability observability(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& sizes) {
  const Eigen::Index n = jacobian.cols();
  Eigen::MatrixXd scaled = Eigen::MatrixXd::Zero(std::max(jacobian.rows(), n), n);
  scaled.topRows(jacobian.rows()) = jacobian;
  const Eigen::VectorXd lengths = scaled.colwise().norm();
  Eigen::VectorXd effects = lengths;
  double no_effect = 0;
  if (sizes.size() > 0) {
    // After rounding, no effect is 1e-17 or so, which scaling would make as long as any other.
    effects = lengths.cwiseProduct(sizes);
    no_effect = kNoEffect * std::max(effects.maxCoeff(), 1.0);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    if (effects[i] > no_effect)
      scaled.col(i) /= lengths[i];
    else
      scaled.col(i).setZero();
  }
  const stats::SingularValues svd = stats::singular_values(scaled);
  Observability o;
  o.singular_values = svd.values.reverse();  // Eigen's fall
  o.directions = svd.right.rowwise().reverse();
  o.condition_indices.resize(n);
  const double largest_value = o.singular_values[n - 1];
  for (Eigen::Index j = 0; j < n; ++j) {
    // After rounding, a zero is 1e-16 of the largest.
    const bool zero = o.singular_values[j] <= 1e-14 * largest_value;
    o.condition_indices[j] = zero ? kInfinity : largest_value / o.singular_values[j];
    Eigen::Index largest = 0;
    o.directions.col(j).cwiseAbs().maxCoeff(&largest);
    if (o.directions(largest, j) < 0) o.directions.col(j) *= -1;
  }
  o.variance_inflation = Eigen::VectorXd::Zero(n);
  for (Eigen::Index j = 0; j < n; ++j) {  // sum_j v_ij^2 / mu_j^2
    const double mu = std::max(o.singular_values[j], 1e-14 * largest_value);
    o.variance_inflation += o.directions.col(j).cwiseAbs2() / (mu * mu);
  }
  if (largest_value == 0) o.variance_inflation.setConstant(kInfinity);
  return o;
}

std::string combination_name(const Eigen::VectorXd& direction, std::span<const char* const> names) {
  const double enough = 0.4 * direction.cwiseAbs().maxCoeff();
  std::vector<const char*> with, against;
  double first = 0;
  for (Eigen::Index i = 0; i < direction.size(); ++i) {
    if (std::abs(direction[i]) < enough) continue;
    if (first == 0) first = direction[i];
    (direction[i] * first > 0 ? with : against).push_back(names[static_cast<std::size_t>(i)]);
  }
  std::string name = fmt::format("{}", fmt::join(with, " with "));
  if (!against.empty()) name += fmt::format(" against {}", fmt::join(against, " with "));
  return name;
}

}  // namespace surveymc::estimate
