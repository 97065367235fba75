#pragma once
/// Small linear systems of fixed size, most of them symmetric, for any scalar type. The compiler unrolls all loops; all
/// lanes take the same path.
#include <array>
#include <cstddef>

#include "simd/lanes.h"

namespace surveymc::simd {

/// Lower triangle of a symmetric N x N matrix, row by row: (i, j) at i (i + 1) / 2 + j, j <= i.
template <class T, std::size_t N>
using Symmetric = std::array<T, N*(N + 1) / 2>;

constexpr std::size_t packed(std::size_t i, std::size_t j) { return i * (i + 1) / 2 + j; }

/// A = L D L': L with unit diagonal (stored below it), and 1/D on the diagonal. A must be positive definite; where it
/// is not, the factor is not finite or has a negative 1/D, and so has the solution: callers test the solution.
template <class T, std::size_t N>
Symmetric<T, N> ldlt(Symmetric<T, N> a) {
#pragma GCC unroll 9
  for (std::size_t j = 0; j < N; ++j) {
    std::array<T, N> ld;  // row j of L D
    T d = a[packed(j, j)];
#pragma GCC unroll 9
    for (std::size_t k = 0; k < j; ++k) {
      ld[k] = a[packed(j, k)];                    // still L D here
      a[packed(j, k)] = ld[k] * a[packed(k, k)];  // times 1/D
      d = fma(-a[packed(j, k)], ld[k], d);
    }
    a[packed(j, j)] = T(1.0) / d;
#pragma GCC unroll 9
    for (std::size_t i = j + 1; i < N; ++i) {
      T s = a[packed(i, j)];
#pragma GCC unroll 9
      for (std::size_t k = 0; k < j; ++k) s = fma(-a[packed(i, k)], a[packed(j, k)], s);
      a[packed(i, j)] = s;
    }
  }
  return a;
}

/// Solves A x = b from ldlt(A).
template <class T, std::size_t N>
std::array<T, N> ldlt_solve(const Symmetric<T, N>& f, std::array<T, N> x) {
#pragma GCC unroll 8
  for (std::size_t i = 0; i < N; ++i)
#pragma GCC unroll 8
    for (std::size_t k = 0; k < i; ++k) x[i] = fma(-f[packed(i, k)], x[k], x[i]);
#pragma GCC unroll 8
  for (std::size_t i = 0; i < N; ++i) x[i] = x[i] * f[packed(i, i)];
#pragma GCC unroll 8
  for (std::size_t back = 1; back < N; ++back) {
    const std::size_t i = N - 1 - back;
#pragma GCC unroll 8
    for (std::size_t k = i + 1; k < N; ++k) x[i] = fma(-f[packed(k, i)], x[k], x[i]);
  }
  return x;
}

/// Full N x N matrix, row by row.
template <class T, std::size_t N>
using Square = std::array<T, N * N>;

/// A = L U: L with unit diagonal below the diagonal, U above it, and 1 / U_ii on it. No pivoting: meant for matrices
/// whose symmetric part is positive definite, as a positive definite matrix with a small perturbation. Where a pivot
/// vanishes the factor is not finite, and so is the solution: callers test the solution.
template <class T, std::size_t N>
Square<T, N> lu(Square<T, N> a) {
#pragma GCC unroll 8
  for (std::size_t k = 0; k < N; ++k) {
    a[k * N + k] = T(1.0) / a[k * N + k];
#pragma GCC unroll 8
    for (std::size_t i = k + 1; i < N; ++i) {
      const T factor = a[i * N + k] * a[k * N + k];
      a[i * N + k] = factor;
#pragma GCC unroll 8
      for (std::size_t j = k + 1; j < N; ++j) a[i * N + j] = fma(-factor, a[k * N + j], a[i * N + j]);
    }
  }
  return a;
}

/// Solves A x = b from lu(A).
template <class T, std::size_t N>
std::array<T, N> lu_solve(const Square<T, N>& f, std::array<T, N> x) {
#pragma GCC unroll 8
  for (std::size_t i = 0; i < N; ++i)
#pragma GCC unroll 8
    for (std::size_t k = 0; k < i; ++k) x[i] = fma(-f[i * N + k], x[k], x[i]);
#pragma GCC unroll 8
  for (std::size_t back = 1; back <= N; ++back) {
    const std::size_t i = N - back;
#pragma GCC unroll 8
    for (std::size_t k = i + 1; k < N; ++k) x[i] = fma(-f[i * N + k], x[k], x[i]);
    x[i] = x[i] * f[i * N + i];
  }
  return x;
}

}  // namespace surveymc::simd
