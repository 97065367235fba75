#pragma once
/// Control variates: a quantity y is compared, trial by trial, with a control l whose mean and covariance are known
/// exactly (the first-order prediction evaluated on the same noise). What they have in common is chance and is taken
/// out; what remains is nonlinearity. Works for means, standard deviations and covariances.
///
/// Each estimate (mean of y_i; mean of y_i y_j less the product of the means) is to first order the mean of a per-trial
/// term. That term is regressed on l_i, l_j and l_i l_j, and what the regression explains is replaced by its known
/// mean: the variance can only become smaller. Intervals follow from the variance of what is left.
///
/// Antithetic pairs (antithetic.h; trials y+, y- of draws z, -z; h = (y+ + y-) / 2, d = (y+ - y-) / 2) go the same way
/// with the pair as the unit and pair means in the place of values. The control of a pair is (l, -l): l_i and l_j have
/// the pair mean 0 and drop out, l_i l_j stays. The term of the mean is h_i; that of the covariance is the pair mean of
/// (y_i - m_i)(y_j - m_j), which is
///   d_i d_j + (h_i - m_i)(h_j - m_j),
/// the part of the half-differences and the part of the half-sums. Both are even in z, as is their control l_i l_j, and
/// one regression of their sum is the sum of one regression for each; its residual has their covariance in it, which
/// two intervals put together would miss.
///   Why this pays: with y = l + q + c + ... (orders one, two, three in z) a trial leaves
///     y^2 - l^2 = 2 l q + (q^2 + 2 l c) + ...,
/// third order first. l q is odd in z, so that h^2 + d^2 - l^2 = q^2 + 2 l c + ... has none of it: what is left is of
/// fourth order, and its variance of order eight instead of six.
/// The price: fourth-order terms have heavy tails, and the interval of the standard deviation is a little too narrow
/// with few pairs (the toy model of the tests: it holds 90 % with 500 pairs, 93 % with 2000, 95 % with 8000).
///
/// Trials that fail have no y, but their draws are known and so is their control. What is estimated is of the trials
/// that do not fail: with c = 1 of these and 0 of the failed, E[c y] / E[c]. The control's known mean is that over
/// *all* trials, so it is held against the sample mean over all of them, and the ratio enters as every mean does, by
/// its per-trial term (y - ratio) c / E[c]. Dropping the failed trials from the control's mean instead would shift the
/// estimate by what failure and control have in common.
#include <array>

#include "stats/intervals.h"
#include "stats/moments.h"

namespace surveymc::stats {

/// An estimate without and with its control.
struct ControlledEstimate {
  double plain = 0, controlled = 0;
  Interval plain_interval, controlled_interval;
  /// Variance of the plain estimate from as many *independent* trials over that of the controlled one: how many times
  /// fewer trials do for one interval. (Of antithetic pairs the plain estimate above is another: that of the pairs.)
  double variance_reduction = 1;
};

/// The tallied vector of a pair (i, j) of quantities: y_i, y_j, l_i, l_j, y_i y_j, l_i l_j, each less its prediction,
/// so that the controls have mean zero. n x 6.
Eigen::MatrixXd control_columns(const Eigen::Ref<const Eigen::VectorXd>& y_i,
                                const Eigen::Ref<const Eigen::VectorXd>& y_j,
                                const Eigen::Ref<const Eigen::VectorXd>& l_i,
                                const Eigen::Ref<const Eigen::VectorXd>& l_j);

/// Columns of the trials that failed: those of control_columns() with y = 0. If the trials are antithetic pairs, of all
/// trials whose pair has one that failed, and their pair_means().
Eigen::MatrixXd lost_columns(const Eigen::Ref<const Eigen::VectorXd>& l_i,
                             const Eigen::Ref<const Eigen::VectorXd>& l_j);

/// Moments of lost_columns(); null: no trial failed.
struct LostTrials {
  const Moments *trials = nullptr, *pairs = nullptr;
};

/// Mean of y_i less its prediction, from the moments of the columns of (i, i); `control_variance` is that of l_i.
/// Here and below: if the trials are antithetic pairs, `pairs` has the moments of the pair_means() of the columns.
/// `columns` and `pairs` are of the trials that did not fail, `lost` is of the others.
ControlledEstimate controlled_mean(const Moments& columns, double control_variance, double confidence,
                                   const Moments* pairs = nullptr, const LostTrials& lost = {});

/// Standard deviation of y_i from the columns of (i, i); `control_variance` is the known one of l_i.
ControlledEstimate controlled_sd(const Moments& columns, double control_variance, double confidence,
                                 const Moments* pairs = nullptr, const LostTrials& lost = {});

/// Covariance of y_i and y_j; `control_covariance` is the known one of l_i and l_j.
ControlledEstimate controlled_covariance(const Moments& columns, double control_covariance, double confidence,
                                         const Moments* pairs = nullptr, const LostTrials& lost = {});

}  // namespace surveymc::stats
