#include "stats/antithetic.h"

#include <cassert>

namespace surveymc::stats {

using Eigen::Index;

Eigen::MatrixXd pair_means(const Eigen::Ref<const Eigen::MatrixXd>& x) {
  assert(x.rows() % 2 == 0);
  Eigen::MatrixXd mean(x.rows() / 2, x.cols());
  for (Index c = 0; c < x.cols(); ++c)
    for (Index j = 0; j < mean.rows(); ++j) mean(j, c) = (x(2 * j, c) + x(2 * j + 1, c)) / 2;
  return mean;
}

Eigen::MatrixXd pair_columns(const Eigen::Ref<const Eigen::MatrixXd>& x) {
  Eigen::MatrixXd columns(x.rows() / 2, 2 * x.cols());
  columns.leftCols(x.cols()) = pair_means(x);
  columns.rightCols(x.cols()) = pair_means(x.cwiseAbs2());
  return columns;
}

Eigen::MatrixXd paired_covariance(const Moments& trials, const Moments& pairs) {
  const Index d = trials.mean.size();
  const double p = static_cast<double>(pairs.count);
  // The trials' sum of squares is 2 S(h h) + 2 sum d d'.
  return trials.squares / (2 * p) + pairs.squares.topLeftCorner(d, d) / (p * (p - 1));
}

SampleSummary summarise_pairs(const Moments& trials, const Moments& pairs, Index i) {
  const Index square = trials.mean.size() + i;
  const double p = static_cast<double>(pairs.count), mean = pairs.mean[i], even = pairs.squares(i, i);
  const double variance = trials.squares(i, i) / (2 * p) + even / (p * (p - 1));
  // u = pair mean of (y - m)^2 is that of y^2, less 2 m h, and a constant.
  const double of_u =
      (pairs.squares(square, square) - 4 * mean * pairs.squares(i, square) + 4 * mean * mean * even) / (p - 1);
  return {pairs.count,       mean, variance, even / (p - 1), 1 + of_u / (variance * variance), trials.skewness(i),
          trials.kurtosis(i)};
}

Interval paired_binomial_interval(std::uint64_t successes, std::uint64_t pairs, double confidence) {
  return {binomial_interval(successes / 2, pairs, confidence).lo,
          binomial_interval((successes + 1) / 2, pairs, confidence).hi};
}

}  // namespace surveymc::stats
