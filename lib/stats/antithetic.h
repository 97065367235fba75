#pragma once
/// Statistics of antithetic pairs: trials y+ and y- of one distribution whose draws are z and -z. The two depend on
/// each other; pairs do not. So a pair is the unit of every standard error here, and P pairs are n = 2 P trials.
///
/// With the half-sum h = (y+ + y-) / 2, which is even in z, and the half-difference d = (y+ - y-) / 2, which is odd,
///   E y = E h,   E d = 0,   E h d = 0,
///   cov(y_i, y_j) = cov(h_i, h_j) + E d_i d_j,
/// since the mean of y_i y_j over a pair is h_i h_j + d_i d_j. Hence, over the pairs (sums S about the mean),
///   mean        mean of h, variance S(h h) / (P - 1) / P;
///   covariance  S(h h) / (P - 1) + sum d d' / P, unbiased: E d is known and takes no degree of freedom;
///   its error   to first order the mean over the pairs of u = mean of (y_i - m_i)(y_j - m_j) over the pair.
/// Of a quantity linear in z h is its mean: the pairs then have all of its mean and half the trials' information on its
/// variance, as many chi-squared degrees of freedom as there are pairs. What pairs gain for the variance they gain with
/// a control variate (control_variate.h).
#include <Eigen/Core>

#include "stats/sample_summary.h"

namespace surveymc::stats {

/// Means of rows 2j and 2j + 1: n x d -> n / 2 x d, n even.
Eigen::MatrixXd pair_means(const Eigen::Ref<const Eigen::MatrixXd>& x);

/// What is tallied of pairs beside the moments of their n trials (x: n x d, one quantity a column): pair means of x,
/// and pair means of x^2. n / 2 x 2 d. Take quantities less their prediction, so that squares keep their digits.
Eigen::MatrixXd pair_columns(const Eigen::Ref<const Eigen::MatrixXd>& x);

/// Of component i, from the moments of the trials and those of pair_columns().
SampleSummary summarise_pairs(const Moments& trials, const Moments& pairs, Eigen::Index i);

/// Unbiased covariance of the quantities, d x d, from the same.
Eigen::MatrixXd paired_covariance(const Moments& trials, const Moments& pairs);

/// Probability of an event seen `successes` times in 2 `pairs` trials: the exact interval (intervals.h) as if both
/// trials of a pair always gave the same, which no dependence within pairs makes too narrow. Half a pair is rounded to
/// the safe side.
Interval paired_binomial_interval(std::uint64_t successes, std::uint64_t pairs, double confidence);

}  // namespace surveymc::stats
