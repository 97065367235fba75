#pragma once
#include <cstdint>

#include <Eigen/Core>

namespace surveymc::stats {

/// Likelihood-ratio test that normal vectors with sample covariance `sample` (unbiased, from `count` vectors, mean
/// unknown) have covariance `predicted`:
///   LR = (n-1) ( tr(P^-1 S) - ln det(P^-1 S) - d ),  chi-squared with d (d+1) / 2 degrees under the null,
/// with Bartlett's correction 1 - (2 d + 1 - 2 / (d + 1)) / (6 (n - 1)) (Muirhead 1982, theorem 8.4.10).
struct WishartTest {
  /// Corrected; infinite when `predicted` is not positive definite. NaN, as p_value, where there is nothing to test:
  /// of no more vectors than dimensions, or of elements that are no numbers.
  double statistic = 0;
  double p_value = 0;  ///< small: the matrices differ
};
WishartTest wishart_test(const Eigen::MatrixXd& sample, const Eigen::MatrixXd& predicted, std::uint64_t count);

}  // namespace surveymc::stats
