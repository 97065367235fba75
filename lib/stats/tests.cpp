#include "stats/tests.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "stats/intervals.h"

namespace surveymc {

WishartTest wishart_test(const Eigen::MatrixXd& sample, const Eigen::MatrixXd& predicted, std::uint64_t count) {
  const double d = static_cast<double>(predicted.rows()), n = static_cast<double>(count) - 1;
  const Eigen::LLT<Eigen::MatrixXd> factor(predicted);
  if (factor.info() != Eigen::Success) return {std::numeric_limits<double>::infinity(), 0};
  // L^-1 S L^-T has the eigenvalues of P^-1 S and is symmetric.
  const Eigen::MatrixXd half = factor.matrixL().solve(sample);
  const Eigen::MatrixXd whitened = factor.matrixL().solve(half.transpose());
  const Eigen::VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(whitened, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(eigenvalues.minCoeff() > 0)) return {std::numeric_limits<double>::infinity(), 0};
  const double lr = n * (eigenvalues.sum() - eigenvalues.array().log().sum() - d);
  const double statistic = lr * (1 - (2 * d + 1 - 2 / (d + 1)) / (6 * n));
  return {statistic, chi_squared_upper_tail(d * (d + 1) / 2, statistic)};
}

}  // namespace surveymc
