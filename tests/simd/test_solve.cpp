#include "simd/solve.h"

#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "simd/dual.h"
#include "stats/linear_algebra.h"

using namespace surveymc;
using namespace surveymc::simd;

namespace {
Symmetric<double, 6> pack(const Eigen::Matrix<double, 6, 6>& a) {
  Symmetric<double, 6> p;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j <= i; ++j) p[packed(i, j)] = a(static_cast<int>(i), static_cast<int>(j));
  return p;
}
}  // namespace

TEST_CASE("LDL' solves what Eigen solves, to the condition of the matrix") {
  std::mt19937_64 g(1);
  std::normal_distribution<double> n;
  for (const double smallest : {1.0, 1e-3, 1e-6}) {
    Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::NullaryExpr([&] { return n(g); });
    const Eigen::Matrix<double, 6, 6> q = stats::orthonormal_columns(m);
    Eigen::Matrix<double, 6, 1> d = Eigen::Matrix<double, 6, 1>::Ones();
    d[5] = smallest;
    const Eigen::Matrix<double, 6, 6> a = q * d.asDiagonal() * q.transpose();
    const Eigen::Matrix<double, 6, 1> x = Eigen::Matrix<double, 6, 1>::NullaryExpr([&] { return n(g); }), b = a * x;
    std::array<double, 6> rhs;
    for (int i = 0; i < 6; ++i) rhs[static_cast<std::size_t>(i)] = b[i];
    const auto solved = ldlt_solve<double, 6>(ldlt<double, 6>(pack(a)), rhs);
    for (int i = 0; i < 6; ++i)  // forward error: a few eps times the condition number
      CHECK(std::abs(solved[static_cast<std::size_t>(i)] - x[i]) < 20 * 2.2e-16 / smallest * x.norm());
  }
}

TEST_CASE("An indefinite matrix shows a negative 1/D") {
  Eigen::Matrix<double, 6, 6> a = Eigen::Matrix<double, 6, 6>::Identity();
  a(3, 3) = -1;
  CHECK(ldlt<double, 6>(pack(a))[packed(3, 3)] < 0);
}

TEST_CASE("LU solves what Eigen solves where a positive definite matrix is a little unsymmetric") {
  std::mt19937_64 g(2);
  std::normal_distribution<double> n;
  const auto random = [&] { return Eigen::Matrix<double, 6, 6>::NullaryExpr([&] { return n(g); }).eval(); };
  for (const double smallest : {1.0, 1e-3, 1e-6}) {
    const Eigen::Matrix<double, 6, 6> q = stats::orthonormal_columns(random());
    Eigen::Matrix<double, 6, 1> d = Eigen::Matrix<double, 6, 1>::Ones();
    d[5] = smallest;
    const Eigen::Matrix<double, 6, 6> a = q * d.asDiagonal() * q.transpose() + 0.01 * smallest * random();
    const Eigen::Matrix<double, 6, 1> x = Eigen::Matrix<double, 6, 1>::NullaryExpr([&] { return n(g); }), b = a * x;
    Square<double, 6> rows;
    std::array<double, 6> rhs;
    for (int i = 0; i < 6; ++i) {
      rhs[static_cast<std::size_t>(i)] = b[i];
      for (int j = 0; j < 6; ++j) rows[static_cast<std::size_t>(6 * i + j)] = a(i, j);
    }
    const auto solved = lu_solve<double, 6>(lu<double, 6>(rows), rhs);
    for (int i = 0; i < 6; ++i)  // forward error: a few eps times the condition number
      CHECK(std::abs(solved[static_cast<std::size_t>(i)] - x[i]) < 40 * 2.2e-16 / smallest * x.norm());
  }
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
