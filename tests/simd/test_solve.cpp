#include "simd/solve.h"

#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "simd/dual.h"
#include "stats/linear_algebra.h"

using namespace surveymc;
using namespace surveymc::simd;

namespace {
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Symmetric<double, 6> pack(const Matrix6& a) {
  Symmetric<double, 6> p;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j <= i; ++j) p[packed(i, j)] = a(static_cast<int>(i), static_cast<int>(j));
  return p;
}

/// Matrices of eigenvalues 1 and one that is smaller, with `unsymmetric` of it in every element: solve(matrix, right
/// side) has a forward error of `roundings` times the condition number.
template <class Solve>
void check_solutions(unsigned seed, double unsymmetric, double roundings, const Solve& solve) {
  std::mt19937_64 g(seed);
  std::normal_distribution<double> n;
  const auto random = [&] { return Matrix6::NullaryExpr([&] { return n(g); }).eval(); };
  for (const double smallest : {1.0, 1e-3, 1e-6}) {
    const Matrix6 q = stats::orthonormal_columns(random());
    Vector6 d = Vector6::Ones();
    d[5] = smallest;
    Matrix6 a = q * d.asDiagonal() * q.transpose();
    if (unsymmetric > 0) a += unsymmetric * smallest * random();
    const Vector6 x = Vector6::NullaryExpr([&] { return n(g); }), b = a * x;
    std::array<double, 6> rhs;
    Vector6::Map(rhs.data()) = b;
    const std::array<double, 6> solved = solve(a, rhs);
    for (int i = 0; i < 6; ++i)
      CHECK(std::abs(solved[static_cast<std::size_t>(i)] - x[i]) < roundings * 2.2e-16 / smallest * x.norm());
  }
}
}  // namespace

TEST_CASE("LDL' solves what Eigen solves, to the condition of the matrix") {
  check_solutions(1, 0, 20, [](const Matrix6& a, const std::array<double, 6>& b) {
    return ldlt_solve<double, 6>(ldlt<double, 6>(pack(a)), b);
  });
}

TEST_CASE("An indefinite matrix shows a negative 1/D") {
  Matrix6 a = Matrix6::Identity();
  a(3, 3) = -1;
  CHECK(ldlt<double, 6>(pack(a))[packed(3, 3)] < 0);
}

TEST_CASE("LU solves what Eigen solves where a positive definite matrix is a little unsymmetric") {
  check_solutions(2, 0.01, 40, [](const Matrix6& a, const std::array<double, 6>& b) {
    Square<double, 6> rows;
    Eigen::Matrix<double, 6, 6, Eigen::RowMajor>::Map(rows.data()) = a;
    return lu_solve<double, 6>(lu<double, 6>(rows), b);
  });
}

TEST_CASE("Dual numbers differentiate products, quotients and roots") {
  using D = Dual<double, 2>;
  const D x = D::variable(1.7, 0), y = D::variable(0.3, 1);
  const D f = sqrt(x * x + y) / (x - D(2.0) * y);
  const double r = std::sqrt(1.7 * 1.7 + 0.3), den = 1.7 - 0.6;
  CHECK(f.a == Approx(r / den).epsilon(1e-15));
  CHECK(f.d[0] == Approx(1.7 / r / den - r / (den * den)).epsilon(1e-14));
  CHECK(f.d[1] == Approx(0.5 / r / den + 2 * r / (den * den)).epsilon(1e-14));
}
