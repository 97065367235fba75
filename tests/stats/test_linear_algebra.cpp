/// Solutions and factors of lib/stats/linear_algebra.
#include <cmath>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "stats/linear_algebra.h"

using namespace surveymc::stats;
using Eigen::Index;
using Eigen::MatrixXd;

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

TEST_CASE("A lower factor has the rank of its matrix, and that of a definite one is Cholesky's",
          "[stats][linear_algebra]") {
  MatrixXd definite(40, 40);
  for (Index i = 0; i < 40; ++i)
    for (Index j = 0; j < 40; ++j) definite(i, j) = i % 2 == j % 2 ? std::exp(-0.3 * std::abs(double(i - j))) : 0;
  const MatrixXd l = lower_factor(definite);
  CHECK((l - cholesky(definite).lower()).cwiseAbs().maxCoeff() < 1e-14);
  CHECK((l.array() != 0).count() == 2 * (20 * 21) / 2);  // what is independent stays so, exactly
  CHECK(lower_factor(MatrixXd::Identity(6, 6)) == MatrixXd::Identity(6, 6));

  MatrixXd waves(30, 30);  // the first two rows are one: their cosines are
  for (Index i = 0; i < 30; ++i)
    for (Index j = 0; j < 30; ++j) waves(i, j) = std::cos(0.5 * double(std::max<Index>(i, 1) - std::max<Index>(j, 1)));
  const MatrixXd w = lower_factor(waves);
  CHECK((w * w.transpose() - waves).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((w.colwise().norm().array() > 0).count() == 2);
  CHECK(w.col(1).isZero(0));
  CHECK(MatrixXd(w.triangularView<Eigen::StrictlyUpper>()).isZero(0));

  const MatrixXd none{{1, 0.9, -0.9}, {0.9, 1, 0.9}, {-0.9, 0.9, 1}};
  CHECK_THROWS_AS(lower_factor(none), surveymc::InputError);  // it has a negative eigenvalue
  CHECK(lower_factor(MatrixXd(0, 0)).size() == 0);
}
