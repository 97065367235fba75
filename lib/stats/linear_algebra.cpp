#include "stats/linear_algebra.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace surveymc::stats {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <>
SmallSymmetricEigen<2> symmetric_eigen(const Eigen::Matrix2d& a) {
  // Tridiagonal as it is: Eigen's general way would reflect it by the identity.
  const double largest = std::max({std::abs(a(0, 0)), std::abs(a(1, 0)), std::abs(a(1, 1))});
  const double scale = largest == 0 ? 1 : largest;
  const Eigen::Vector2d diagonal(a(0, 0) / scale, a(1, 1) / scale);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeFromTridiagonal(diagonal, Eigen::Matrix<double, 1, 1>(a(1, 0) / scale));
  return {solver.eigenvalues() * scale, solver.eigenvectors()};
}

template <>
SmallSymmetricEigen<3> symmetric_eigen(const Eigen::Matrix3d& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

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
  const Index rank = solver.rank(), unknowns = a.cols();
  VectorXd x = VectorXd::Zero(unknowns);
  if (rank == 0) return x;
  // As solver.solve(b), whose reflections of a vector would be compiled anew.
  MatrixXd c = b;
  c.applyOnTheLeft(solver.householderQ().setLength(rank).adjoint());
  x.head(rank) =
      solver.matrixT().topLeftCorner(rank, rank).triangularView<Eigen::Upper>().solve(VectorXd(c.col(0).head(rank)));
  const MatrixXd& z = solver.matrixQTZ();
  for (Index k = 0; k < rank && rank < unknowns; ++k) {
    const double tau = solver.zCoeffs()[k];
    std::swap(x[k], x[rank - 1]);
    double along = 0;
    for (Index j = rank; j < unknowns; ++j) along += z(k, j) * x[j];
    along += x[rank - 1];
    x[rank - 1] -= tau * along;
    for (Index j = rank; j < unknowns; ++j) x[j] -= tau * z(k, j) * along;
    std::swap(x[k], x[rank - 1]);
  }
  return solver.colsPermutation() * x;
}

Cholesky cholesky(const MatrixXd& a) {
  Cholesky c;
  c.factor_.compute(a);
  return c;
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
