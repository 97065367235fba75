#pragma once
/// Streaming statistics of vectors: what is kept of a million trials.
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace surveymc::stats {

/// Count, mean, full covariance, and third and fourth central moments of every component. Mergeable (Chan, Golub and
/// LeVeque 1979; Pebay 2008), so the memory does not grow with trials.
struct Moments {
  std::uint64_t count = 0;
  Eigen::VectorXd mean;     ///< d
  Eigen::MatrixXd squares;  ///< d x d: sum of (x - mean)(x - mean)'
  Eigen::VectorXd cubes;    ///< d: sum of (x - mean)^3
  Eigen::VectorXd fourths;  ///< d: sum of (x - mean)^4

  Moments() = default;
  explicit Moments(Eigen::Index dimension);
  /// Of n values of d quantities: x is n x d, one quantity a column. Two passes; sums run in eight fixed partial sums.
  static Moments of(const Eigen::Ref<const Eigen::MatrixXd>& x);

  void merge(const Moments& other);
  Eigen::MatrixXd covariance() const { return squares / static_cast<double>(count - 1); }
  double variance(Eigen::Index i) const { return squares(i, i) / static_cast<double>(count - 1); }
  double skewness(Eigen::Index i) const;
  double kurtosis(Eigen::Index i) const;  ///< 3 for a normal distribution
};

}  // namespace surveymc::stats
