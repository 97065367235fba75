#pragma once
/// Control variates: a quantity y is compared, trial by trial, with a control l whose mean and covariance are known
/// exactly (the first-order prediction evaluated on the same noise). Chance moves both in the same way, and this common
/// part is removed; nonlinearity remains. Works for means, standard deviations and covariances.
///
/// Each estimate (mean of y_i; mean of y_i y_j less the product of the means) is to first order the mean of a per-trial
/// term. That term is regressed on l_i, l_j and l_i l_j. The part that the regression explains is replaced by its known
/// mean, which can only make the variance smaller. Intervals follow from the variance of the residual.
///
/// Antithetic pairs (antithetic.h; trials y+, y- of draws z, -z; h = (y+ + y-) / 2, d = (y+ - y-) / 2) are treated
/// alike, with the pair as the unit and pair means in the place of values. The control of a pair is (l, -l): l_i and
/// l_j have the pair mean 0 and drop out, l_i l_j stays. The term of the mean is h_i; that of the covariance is the
/// pair mean of (y_i - m_i)(y_j - m_j), which is
///   d_i d_j + (h_i - m_i)(h_j - m_j),
/// the part of the half-differences and the part of the half-sums. Both are even in z, as is their control l_i l_j. One
/// regression of their sum is the sum of one regression for each part. The residual of the one regression includes the
/// covariance of the two parts, which two separate intervals would miss.
///   Why pairs help: with y = l + q + c + ... (orders one, two, three in z) a single trial leaves
///     y^2 - l^2 = 2 l q + (q^2 + 2 l c) + ...,
/// which begins with the third order. l q is odd in z, so that it vanishes from h^2 + d^2 - l^2 = q^2 + 2 l c + ...:
/// the residual of a pair is of fourth order, and its variance of order eight instead of six.
/// The price: fourth-order terms have heavy tails. What the regression on l^2 leaves of l^4 is the fourth Hermite
/// polynomial He4(l), of skewness 14.7. Few pairs lack its largest values, and their standard error is too small with
/// them: a normal interval at 95 % holds 0.77 of the truth with 100 pairs, 0.91 with 1000, 0.94 with 5000. So
/// covariances and standard deviations from P pairs have in the place of the normal quantile z that of He4,
///   z (1 + 0.235 (z / 1.96)^1.7 (1000 / P)^0.82),
/// a fit to simulations (50 <= P <= 5000, 1 <= z <= 3.1) that is right to 8 % of the quantile. Residuals of lighter
/// tails get intervals that hold more than they claim.
///
/// Trials that fail have no y, but their draws are known and so is their control. The estimate is that of the trials
/// that do not fail: with c = 1 for these and c = 0 for the failed, E[c y] / E[c]. The control's known mean is that
/// over *all* trials, so the sample mean of the control is taken over all trials, too. The ratio enters as every mean
/// does, by its per-trial term (y - ratio) c / E[c]. If the sample mean of the control left out the failed trials, a
/// correlation of failure and control would shift the estimate.
#include <array>

#include "stats/intervals.h"
#include "stats/moments.h"

namespace surveymc::stats {

/// An estimate without and with its control.
struct ControlledEstimate {
  double plain = 0, controlled = 0;
  Interval plain_interval, controlled_interval;
  /// Variance of the plain estimate from as many *independent* trials over that of the controlled one: how many times
  /// fewer trials give the same interval. (With antithetic pairs the plain estimate above is that of the pairs
  /// instead.)
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
