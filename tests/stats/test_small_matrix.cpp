/// Small matrices by plain loops: the same bits as Eigen's own, which are compiled once for all sizes.
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "stats/linear_algebra.h"
#include "stats/matrices.h"
#include "stats/small_matrix.h"

using namespace surveymc::stats;
using Eigen::Index;
using Eigen::MatrixXd;

namespace {

std::mt19937_64& generator() {
  static std::mt19937_64 g(20);
  return g;
}

/// Of very different sizes.
MatrixXd random_matrix(Index rows, Index columns) {
  std::normal_distribution<double> normal;
  MatrixXd a(rows, columns);
  for (Index j = 0; j < columns; ++j)
    for (Index i = 0; i < rows; ++i) a(i, j) = normal(generator()) * std::exp(3 * normal(generator()));
  return a;
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0 || (std::isnan(a) && std::isnan(b)); }
bool same_bits(const MatrixXd& a, const MatrixXd& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  for (Index i = 0; i < a.size(); ++i)
    if (!same_bits(a.data()[i], b.data()[i])) return false;
  return true;
}

template <int N>
void check_cholesky() {
  const MatrixXd root = random_matrix(N, N);
  MatrixXd a = root * root.transpose();
  const bool spoilt = generator()() % 4 == 0;
  if (spoilt) a(N - 1, N - 1) *= -1;
  const SmallCholesky<N> small{Eigen::Matrix<double, N, N>(a)};
  const Cholesky large = cholesky(a);
  REQUIRE(small.positive_definite() == large.positive_definite());
  if (spoilt) return;
  CHECK(same_bits(MatrixXd(small.lower()).triangularView<Eigen::Lower>(), large.lower()));
  const MatrixXd b = random_matrix(N, 3);
  MatrixXd x = b;
  for (Index i = 0; i < b.cols(); ++i) small.solve_in_place(&x(0, i));
  CHECK(same_bits(x, large.solve(b)));
}

template <int Rows, int Inner, int Columns>
void check_product() {
  const Eigen::Matrix<double, Rows, Inner> a = random_matrix(Rows, Inner);
  const Eigen::Matrix<double, Inner, Columns> b = random_matrix(Inner, Columns);
  const Eigen::Matrix<double, Rows, Columns> product = a * b;
  CHECK(same_bits(product_by_halves(a, b), product));
}

template <int N>
void check_dot() {
  const Eigen::Matrix<double, N, 2> a = random_matrix(N, 2);
  CHECK(same_bits(dot_by_halves<N>(a.data(), a.data() + N), a.col(0).dot(a.col(1))));
}

}  // namespace

TEST_CASE("Small Cholesky factors and solutions have the bits of large ones", "[stats][linear_algebra]") {
  for (int i = 0; i < 200; ++i) {
    check_cholesky<3>();
    check_cholesky<9>();
    check_cholesky<12>();
  }
}

TEST_CASE("Three unknowns: rows and vectors are solved with Eigen's bits", "[stats][linear_algebra]") {
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d root = random_matrix(3, 3), a = root * root.transpose();
    const Eigen::Vector3d b = random_matrix(3, 1);
    const Eigen::LLT<Eigen::Matrix3d> factor(a);
    const SmallCholesky<3> small(a);
    if (!small.positive_definite()) continue;
    CHECK(same_bits(small.solve(b), Eigen::Vector3d(factor.solve(b))));
    Eigen::Matrix<double, 3, 2, Eigen::RowMajor> rows;
    rows << b, b;
    rows = factor.solve(rows).eval();
    Eigen::Vector3d x = b;
    small.solve_row_in_place(x.data());
    CHECK(same_bits(x, rows.col(1)));
  }
}

TEST_CASE("Products of small matrices have the bits of Eigen's", "[stats][linear_algebra]") {
  for (int i = 0; i < 200; ++i) {
    check_product<2, 2, 2>();
    check_product<2, 3, 2>();
    check_product<2, 6, 2>();
    check_product<3, 3, 1>();
    check_product<6, 4, 6>();
    check_product<6, 6, 1>();
    check_product<6, 6, 6>();
    check_dot<3>();
    check_dot<6>();
    check_dot<9>();
    check_dot<12>();
  }
}

TEST_CASE("Products over three or six columns have the bits of Eigen's, small and large", "[stats][linear_algebra]") {
  for (Index rows = 1; rows < 14; ++rows)
    for (Index columns = 1; columns < 14; ++columns) {
      const Eigen::Matrix<double, Eigen::Dynamic, 3> a3 = random_matrix(rows, 3);
      const Eigen::Matrix<double, 3, Eigen::Dynamic> b3 = random_matrix(3, columns);
      CHECK(same_bits(product_over(a3, b3), MatrixXd(a3 * b3)));
      const Eigen::Matrix<double, Eigen::Dynamic, 6> a6 = random_matrix(rows, 6);
      const Eigen::Matrix<double, 6, Eigen::Dynamic> b6 = random_matrix(6, columns);
      CHECK(same_bits(product_over(a6, b6), MatrixXd(a6 * b6)));
    }
}

TEST_CASE("The factor's lower triangle is solved with Eigen's bits", "[stats][linear_algebra]") {
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix<double, 6, 6> root = random_matrix(6, 6), a = root * root.transpose();
    const Eigen::Matrix<double, 6, 1> b = random_matrix(6, 1);
    const Eigen::LLT<Eigen::Matrix<double, 6, 6>> factor(a);
    if (factor.info() != Eigen::Success) continue;
    CHECK(same_bits(SmallCholesky<6>(a).solve_lower(b), Eigen::Matrix<double, 6, 1>(factor.matrixL().solve(b))));
  }
}

TEST_CASE("Eigenvectors of 2 x 2 matrices have the bits of the general way", "[stats][linear_algebra]") {
  std::vector<Eigen::Matrix2d> all;
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> special{0, -0.0, 1, -1, 2, 5e-324, 1e308, inf, -inf, nan};
  for (const double a : special)
    for (const double b : special)
      for (const double c : special) all.push_back(Eigen::Matrix2d{{a, 0}, {b, c}});
  for (int i = 0; i < 1000; ++i) all.emplace_back(random_matrix(2, 2));
  for (const Eigen::Matrix2d& a : all) {
    INFO(a(0, 0) << " " << a(1, 0) << " " << a(1, 1));
    const SmallSymmetricEigen<2> small = symmetric_eigen(a);
    const SymmetricEigen general = symmetric_eigen(MatrixXd(a));
    CHECK(same_bits(small.values, general.values));
    CHECK(same_bits(small.vectors, general.vectors));
  }
}

TEST_CASE("The shortest least-squares solution is that of the singular values", "[stats][linear_algebra]") {
  for (const Index rank : {1, 2, 4}) {
    const MatrixXd a = MatrixXd::Random(7, rank) * MatrixXd::Random(rank, 4);
    const Eigen::VectorXd b = Eigen::VectorXd::Random(7);
    const SymmetricEigen eigen = symmetric_eigen(a.transpose() * a);
    Eigen::VectorXd shortest = Eigen::VectorXd::Zero(4);
    for (Index i = 4 - rank; i < 4; ++i)
      shortest += eigen.vectors.col(i) * (eigen.vectors.col(i).dot(a.transpose() * b) / eigen.values[i]);
    CHECK((least_squares_solution(a, b, 1e-9) - shortest).norm() < 1e-10 * shortest.norm());
  }
  CHECK(least_squares_solution(MatrixXd::Zero(3, 2), Eigen::VectorXd::Ones(3), 1e-9).isZero());
}

TEST_CASE("Factors of symmetric matrices: inverse, solution, determinant", "[stats][linear_algebra]") {
  MatrixXd a{{4, 1, 0}, {1, 3, 1}, {0, 1, 2}};
  const SymmetricFactor f = symmetric_factor(a);
  CHECK(f.positive_definite());
  CHECK((f.inverse() * a - MatrixXd::Identity(3, 3)).norm() < 1e-14);
  CHECK((a * f.solve(Eigen::Vector3d(1, 2, 3)) - Eigen::Vector3d(1, 2, 3)).norm() < 1e-14);
  CHECK(std::abs(f.log_determinant() - std::log(18.0)) < 1e-14);
  a(2, 2) = -2;
  CHECK_FALSE(symmetric_factor(a).positive_definite());
}
