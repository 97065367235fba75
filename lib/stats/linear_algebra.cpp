#include "stats/linear_algebra.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "base/error.h"

namespace surveymc::stats {

using Eigen::MatrixXd;
using Eigen::VectorXd;

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <int N>
SmallSymmetricEigen<N> symmetric_eigen(const Eigen::Matrix<double, N, N>& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}
template SmallSymmetricEigen<2> symmetric_eigen(const Eigen::Matrix2d& a);
template SmallSymmetricEigen<3> symmetric_eigen(const Eigen::Matrix3d& a);

VectorXd symmetric_eigenvalues(const MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

SingularValues singular_values(const MatrixXd& a) {
  const Eigen::JacobiSVD<MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixV()};
}

MatrixXd orthonormal_columns(const MatrixXd& a) {
  return Eigen::HouseholderQR<MatrixXd>(a).householderQ() * MatrixXd::Identity(a.rows(), a.cols());
}

MatrixXd orthogonal_complement(const MatrixXd& a) {
  const MatrixXd q = Eigen::HouseholderQR<MatrixXd>(a).householderQ() * MatrixXd::Identity(a.rows(), a.rows());
  return q.rightCols(a.rows() - a.cols());
}

VectorXd least_squares_solution(const MatrixXd& a, const VectorXd& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
  solver.setThreshold(threshold);
  solver.compute(a);
  return solver.solve(b);
}

Cholesky cholesky(const MatrixXd& a) {
  Cholesky c;
  c.factor_.compute(a);
  return c;
}

/// L of lower_factor(), unless there is none.
static MatrixXd unchecked_factor(const MatrixXd& c) {
  const Eigen::Index n = c.rows();
  // Pivots of a matrix of rank r are rounding from the r-th on.
  const double rounding = 1e-13 * static_cast<double>(n);
  const Cholesky definite = cholesky(c);
  MatrixXd l = MatrixXd::Zero(n, n);
  if (definite.positive_definite()) l = definite.lower();
  if (l.diagonal().cwiseAbs2().minCoeff() > rounding) return l;
  // Leaves out the columns of such pivots. Eigen's LDLT divides by them: it orders pivots by the given diagonal, of a
  // correlation all ones, and what lies below a pivot of rounding is rounding, too, but may be far larger.
  l.setZero();
  for (Eigen::Index j = 0; j < n; ++j) {
    const double pivot = c(j, j) - l.row(j).head(j).squaredNorm();
    if (pivot <= rounding) continue;
    l(j, j) = std::sqrt(pivot);
    for (Eigen::Index i = j + 1; i < n; ++i) l(i, j) = (c(i, j) - l.row(i).head(j).dot(l.row(j).head(j))) / l(j, j);
  }
  return l;
}

MatrixXd lower_factor(const MatrixXd& c) {
  if (c.size() == 0) return c;
  MatrixXd l = unchecked_factor(c);
  const double error = (l * l.transpose() - c).cwiseAbs().maxCoeff();
  require(error < 1e-6, "a correlation matrix of {} rows has no factor: it is {:.2g} off", c.rows(), error);
  return l;
}

MatrixXd Cholesky::lower() const { return factor_.matrixL(); }
MatrixXd Cholesky::solve(const MatrixXd& b) const { return factor_.solve(b); }
MatrixXd Cholesky::solve_lower(const MatrixXd& b) const { return factor_.matrixL().solve(b); }
MatrixXd Cholesky::solve_upper(const MatrixXd& b) const { return factor_.matrixU().solve(b); }

SymmetricFactor symmetric_factor(const MatrixXd& a) {
  SymmetricFactor f;
  f.factor_.compute(a);
  return f;
}

bool SymmetricFactor::positive_definite() const {
  return factor_.info() == Eigen::Success && factor_.vectorD().minCoeff() > 0;
}
double SymmetricFactor::log_determinant() const { return factor_.vectorD().array().log().sum(); }
VectorXd SymmetricFactor::solve(const VectorXd& b) const { return factor_.solve(b); }
MatrixXd SymmetricFactor::inverse() const { return factor_.solve(MatrixXd::Identity(factor_.rows(), factor_.cols())); }

MatrixXd symmetric_inverse(const MatrixXd& a) { return symmetric_factor(a).inverse(); }

}  // namespace surveymc::stats
