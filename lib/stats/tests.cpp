#include "stats/tests.h"

#include <cmath>

#include "base/units.h"
#include "stats/intervals.h"
#include "stats/linear_algebra.h"

namespace surveymc::stats {

WishartTest wishart_test(const Eigen::MatrixXd& sample, const Eigen::MatrixXd& predicted, std::uint64_t count) {
  const double d = static_cast<double>(predicted.rows()), n = static_cast<double>(count) - 1;
  // As many values as dimensions or fewer span no volume, whatever their covariance.
  if (count <= static_cast<std::uint64_t>(predicted.rows()) || sample.hasNaN() || predicted.hasNaN())
    return {kNaN, kNaN};
  const Cholesky factor = cholesky(predicted);
  if (!factor.positive_definite()) return {kInfinity, 0};
  // L^-1 S L^-T has the eigenvalues of P^-1 S and is symmetric.
  const Eigen::VectorXd eigenvalues = symmetric_eigenvalues(factor.solve_lower(factor.solve_lower(sample).transpose()));
  if (!(eigenvalues.minCoeff() > 0)) return {kInfinity, 0};
  const double lr = n * (eigenvalues.sum() - eigenvalues.array().log().sum() - d);
  const double statistic = lr * (1 - (2 * d + 1 - 2 / (d + 1)) / (6 * n));
  return {statistic, chi_squared_upper_tail(d * (d + 1) / 2, statistic)};
}

}  // namespace surveymc::stats
