#pragma once
/// Sums, products and the Cholesky factor of matrices whose size the compiler knows, by plain loops. Eigen's own take
/// seconds to compile for each new size. Terms are added in the order in which Eigen adds them: the same bits.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>

namespace surveymc::stats {

/// term(First) + ... + term(First + Count - 1), added by halves.
template <int Count, int First = 0, class Term>
double sum_by_halves(const Term& term) {
  if constexpr (Count == 1) {
    return term(First);
  } else {
    constexpr int half = Count / 2;
    return sum_by_halves<half, First>(term) + sum_by_halves<Count - half, First + half>(term);
  }
}

/// Scalar product of two columns of N numbers, added by halves.
template <int N>
double dot_by_halves(const double* a, const double* b) {
  return sum_by_halves<N>([=](int i) { return a[i] * b[i]; });
}

/// a b, column by column, each element added by halves. Eigen's own product of these sizes is a call for each of its
/// elements.
template <int Rows, int Inner, int Columns>
Eigen::Matrix<double, Rows, Columns> product_by_halves(const Eigen::Matrix<double, Rows, Inner>& a,
                                                       const Eigen::Matrix<double, Inner, Columns>& b) {
  Eigen::Matrix<double, Rows, Columns> c;
  for (int j = 0; j < Columns; ++j) {
#pragma GCC ivdep
#ifndef __clang__  // which makes vectors of what it has unrolled
#pragma GCC unroll 1
#endif
    for (int i = 0; i < Rows; ++i) c(i, j) = sum_by_halves<Inner>([&](int k) { return a(i, k) * b(k, j); });
  }
  return c;
}

/// The factor L of A = L L', A symmetric and positive definite; its lower triangle is read.
template <int N>
class SmallCholesky {
 public:
  using Matrix = Eigen::Matrix<double, N, N>;

  explicit SmallCholesky(const Matrix& a) : l_(a) { positive_definite_ = factor(); }

  /// False where a pivot was not positive.
  bool positive_definite() const { return positive_definite_; }
  /// L, in the lower triangle.
  const Matrix& lower() const { return l_; }

  /// L^-1 b. What is taken from a row is added by halves.
  Eigen::Matrix<double, N, 1> solve_lower(Eigen::Matrix<double, N, 1> b) const {
    solve_rows_from<0>(b);
    return b;
  }
  /// A^-1 b, for at most three rows. It divides by L's diagonal, and solve_in_place multiplies by 1 / L's: as Eigen
  /// does for one vector and for the columns of a matrix.
  Eigen::Matrix<double, N, 1> solve(Eigen::Matrix<double, N, 1> b) const {
    static_assert(N <= 3);
    for (int i = 0; i < N; ++i) {
      double sum = 0;
      for (int j = 0; j < i; ++j) sum += l_(i, j) * b[j];
      b[i] = (b[i] - sum) / l_(i, i);
    }
    for (int i = N; i-- > 0;) {
      double sum = 0;
      for (int j = i + 1; j < N; ++j) sum += l_(j, i) * b[j];
      b[i] = (b[i] - sum) / l_(i, i);
    }
    return b;
  }
  /// x becomes A^-1 x, for at most three rows: as Eigen solves for what is stored by rows.
  void solve_row_in_place(double* x) const {
    static_assert(N <= 3);
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < i; ++j) x[i] -= x[j] * l_(i, j);
      x[i] *= 1 / l_(i, i);
    }
    for (int i = N; i-- > 0;) {
      for (int j = i + 1; j < N; ++j) x[i] -= x[j] * l_(j, i);
      x[i] *= 1 / l_(i, i);
    }
  }
  /// x becomes A^-1 x. Rows are solved four by four; what four take from all the others is added first.
  void solve_in_place(double* x) const {
    for (int first = 0; first < N; first += kPanel) {
      const int end = std::min(first + kPanel, N);
      for (int i = first; i < end; ++i) {
        x[i] *= 1 / l_(i, i);
        for (int below = i + 1; below < end; ++below) x[below] -= x[i] * l_(below, i);
      }
      for (int below = end; below < N; ++below) {
        double sum = 0;
        for (int i = first; i < end; ++i) sum += l_(below, i) * x[i];
        x[below] -= sum;
      }
    }
    for (int end = N; end > 0; end -= kPanel) {
      const int first = std::max(end - kPanel, 0);
      for (int i = end; i-- > first;) {
        double sum = 0;
        for (int below = i + 1; below < end; ++below) sum += l_(below, i) * x[below];
        x[i] = (x[i] - sum) * (1 / l_(i, i));
      }
      for (int above = 0; above < first; ++above) {
        double sum = 0;
        for (int i = first; i < end; ++i) sum += l_(i, above) * x[i];
        x[above] -= sum;
      }
    }
  }

 private:
  static constexpr int kPanel = 4;

  template <int Row>
  void solve_rows_from(Eigen::Matrix<double, N, 1>& b) const {
    if constexpr (Row < N) {
      if constexpr (Row > 0) b[Row] -= sum_by_halves<Row>([&](int j) { return l_(Row, j) * b[j]; });
      b[Row] /= l_(Row, Row);
      solve_rows_from<Row + 1>(b);
    }
  }

  bool factor() {
    for (int k = 0; k < N; ++k) {
      double square = 0;
      for (int j = 0; j < k; ++j) square += l_(k, j) * l_(k, j);
      const double pivot = l_(k, k) - square;
      if (pivot <= 0) return false;
      const double root = l_(k, k) = std::sqrt(pivot);
      std::array<double, N> sums{};
      for (int j = 0; j < k; ++j)
        for (int i = k + 1; i < N; ++i) sums[static_cast<std::size_t>(i)] += l_(i, j) * l_(k, j);
      for (int i = k + 1; i < N; ++i) l_(i, k) = (l_(i, k) - sums[static_cast<std::size_t>(i)]) / root;
    }
    return true;
  }

  Matrix l_;
  bool positive_definite_ = false;
};

}  // namespace surveymc::stats
