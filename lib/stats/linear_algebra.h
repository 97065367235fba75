#pragma once
/// Decompositions of matrices whose size is known only when the program runs, and eigenvectors of small ones. Only this
/// module's source file instantiates Eigen's solvers, because each takes ten to thirty seconds to compile.
#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace surveymc::stats {

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< columns, orthonormal, in the order of the values
};
/// Eigenvalues and eigenvectors of a symmetric matrix; its lower triangle is read.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);
template <int N>
struct SmallSymmetricEigen {
  Eigen::Matrix<double, N, 1> values;   ///< ascending
  Eigen::Matrix<double, N, N> vectors;  ///< columns, orthonormal, in the order of the values
};
/// The same for 2 x 2 and 3 x 3 matrices, without memory from the heap.
template <int N>
SmallSymmetricEigen<N> symmetric_eigen(const Eigen::Matrix<double, N, N>& a);
/// Eigenvalues alone, ascending.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

struct SingularValues {
  Eigen::VectorXd values;  ///< falling
  Eigen::MatrixXd right;   ///< V: columns in the order of the values, n x min(m, n)
};
/// Thin singular value decomposition A = U S V' of an m x n matrix, by Jacobi rotations: small values keep their
/// digits.
SingularValues singular_values(const Eigen::MatrixXd& a);

/// Orthonormal basis (m x n) of the column space of an m x n matrix of full rank, m >= n, by Householder reflections.
Eigen::MatrixXd orthonormal_columns(const Eigen::MatrixXd& a);

/// Orthonormal basis (m x (m - n)) of what is orthogonal to the columns of an m x n matrix of full rank, m >= n.
Eigen::MatrixXd orthogonal_complement(const Eigen::MatrixXd& a);

/// The shortest x with least |A x - b|. A pivot below `threshold` of the largest counts as zero.
Eigen::VectorXd least_squares_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold);

/// The factor L of A = L L', A symmetric and positive definite; its lower triangle is read.
class Cholesky {
 public:
  /// False where a pivot was not positive: then no other member may be called.
  bool positive_definite() const { return factor_.info() == Eigen::Success; }
  Eigen::MatrixXd lower() const;
  /// A^-1 b.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;
  /// L^-1 b.
  Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& b) const;
  /// L'^-1 b.
  Eigen::MatrixXd solve_upper(const Eigen::MatrixXd& b) const;

 private:
  friend Cholesky cholesky(const Eigen::MatrixXd& a);
  Eigen::LLT<Eigen::MatrixXd> factor_;
};
Cholesky cholesky(const Eigen::MatrixXd& a);

/// Lower triangular L with L L' = `correlation`, of any rank: a row that depends on those before it ends in zeros, and
/// the column of its own is zero. The factor of the unit matrix is the unit matrix, exactly, and that of a 0 x
/// 0 matrix a 0 x 0 matrix. Throws InputError where L L' is not the matrix to 1e-6: it is then no correlation matrix.
Eigen::MatrixXd lower_factor(const Eigen::MatrixXd& correlation);

/// The factors of A = L D L', A symmetric, with pivots; its lower triangle is read.
class SymmetricFactor {
 public:
  bool positive_definite() const;
  /// ln det A, A positive definite.
  double log_determinant() const;
  /// A^-1 b.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd inverse() const;

 private:
  friend SymmetricFactor symmetric_factor(const Eigen::MatrixXd& a);
  Eigen::LDLT<Eigen::MatrixXd> factor_;
};
SymmetricFactor symmetric_factor(const Eigen::MatrixXd& a);

/// Inverse of a symmetric matrix, by its SymmetricFactor.
Eigen::MatrixXd symmetric_inverse(const Eigen::MatrixXd& a);

}  // namespace surveymc::stats
