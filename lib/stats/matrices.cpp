#include "stats/matrices.h"

#include "stats/small_matrix.h"

namespace surveymc::stats {

using Eigen::Dynamic;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd product(const MatrixXd& a, const MatrixXd& b) { return a * b; }
void set_product(const Eigen::Ref<const MatrixXd>& a, const Eigen::Ref<const MatrixXd>& b, Eigen::Ref<MatrixXd> c) {
  c.noalias() = a * b;
}
template <int N>
MatrixXd product_over(const Eigen::Matrix<double, Dynamic, N>& a, const Eigen::Matrix<double, N, Dynamic>& b) {
  constexpr Eigen::Index kSmall = 20;  // Eigen's bound: products of more elements add one term after the other
  const bool by_halves = a.rows() + N + b.cols() < kSmall;
  MatrixXd c(a.rows(), b.cols());
  for (Eigen::Index j = 0; j < b.cols(); ++j)
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      double terms[N], sum = 0;
      for (int k = 0; k < N; ++k) sum += terms[k] = a(i, k) * b(k, j);
      c(i, j) = by_halves ? sum_by_halves<N>([&](int k) { return terms[k]; }) : sum;
    }
  return c;
}
template MatrixXd product_over(const Eigen::Matrix<double, Dynamic, 3>& a, const Eigen::Matrix<double, 3, Dynamic>& b);
template MatrixXd product_over(const Eigen::Matrix<double, Dynamic, 6>& a, const Eigen::Matrix<double, 6, Dynamic>& b);
MatrixXd transpose_product(const MatrixXd& a, const MatrixXd& b) { return a.transpose() * b; }
MatrixXd product_transpose(const MatrixXd& a, const MatrixXd& b) { return a * b.transpose(); }
Eigen::Matrix3d square(const Eigen::Matrix3Xd& a) { return a * a.transpose(); }

VectorXd times(const MatrixXd& a, const VectorXd& x) { return a * x; }
VectorXd transpose_times(const MatrixXd& a, const VectorXd& x) { return a.transpose() * x; }
void add_times(const MatrixXd& a, const VectorXd& x, VectorXd& y) { y.noalias() += a * x; }

MatrixXd scaled(const MatrixXd& a, const VectorXd& s) {
  MatrixXd c = a;
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    for (Eigen::Index i = 0; i < a.rows(); ++i) c(i, j) = s[i] * a(i, j) * s[j];
  return c;
}

}  // namespace surveymc::stats
