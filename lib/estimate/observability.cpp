#include "estimate/observability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/ranges.h>

#include "base/units.h"
#include "stats/linear_algebra.h"

namespace surveymc::estimate {

Observability observability(const Eigen::Matrix<double, Eigen::Dynamic, 6>& jacobian) {
  Eigen::Matrix<double, Eigen::Dynamic, 6> scaled = jacobian;
  for (int i = 0; i < 6; ++i) {
    const double length = scaled.col(i).norm();
    if (length > 0) scaled.col(i) /= length;
  }
  const stats::SingularValues svd = stats::singular_values(scaled);
  Observability o;
  o.singular_values = svd.values.reverse();  // Eigen's fall
  o.directions = svd.right.rowwise().reverse();
  for (int j = 0; j < 6; ++j) {
    // After rounding, a zero is 1e-16 of the largest.
    const bool zero = o.singular_values[j] < 1e-14 * o.singular_values[5];
    o.condition_indices[j] = zero ? kInfinity : o.singular_values[5] / o.singular_values[j];
    Eigen::Index largest = 0;
    o.directions.col(j).cwiseAbs().maxCoeff(&largest);
    if (o.directions(largest, j) < 0) o.directions.col(j) *= -1;
  }
  o.variance_inflation.setZero();
  for (int j = 0; j < 6; ++j) {  // sum_j v_ij^2 / mu_j^2
    const double mu = std::max(o.singular_values[j], 1e-14 * o.singular_values[5]);
    o.variance_inflation += o.directions.col(j).cwiseAbs2() / (mu * mu);
  }
  return o;
}

std::string combination_name(const Eigen::Matrix<double, 6, 1>& direction) {
  const double enough = 0.4 * direction.cwiseAbs().maxCoeff();
  std::vector<const char*> with, against;
  double first = 0;
  for (int i = 0; i < 6; ++i) {
    if (std::abs(direction[i]) < enough) continue;
    if (first == 0) first = direction[i];
    (direction[i] * first > 0 ? with : against).push_back(parameter_name(i));
  }
  std::string name = fmt::format("{}", fmt::join(with, " with "));
  if (!against.empty()) name += fmt::format(" against {}", fmt::join(against, " with "));
  return name;
}

}  // namespace surveymc::estimate
