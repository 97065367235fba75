#pragma once
/// Control variates: a quantity y is compared, trial by trial, with a control l whose mean and covariance are known
/// exactly (the first-order prediction evaluated on the same noise). What they have in common is chance and is taken
/// out; what remains is nonlinearity. Works for means, standard deviations and covariances.
///
/// Each estimate (mean of y_i; mean of y_i y_j less the product of the means) is to first order the mean of a per-trial
/// term. That term is regressed on l_i, l_j and l_i l_j, and what the regression explains is replaced by its known
/// mean: the variance can only become smaller. Intervals follow from the variance of what is left.
#include <array>

#include "stats/intervals.h"
#include "stats/moments.h"

namespace surveymc {

/// An estimate without and with its control.
struct ControlledEstimate {
  double plain = 0, controlled = 0;
  Interval plain_interval, controlled_interval;
  /// Variance of the plain over that of the controlled estimate: how many times fewer trials do for one interval.
  double variance_reduction = 1;
};

/// The tallied vector of a pair (i, j) of quantities: y_i, y_j, l_i, l_j, y_i y_j, l_i l_j, each less its prediction,
/// so that the controls have mean zero. n x 6.
Eigen::MatrixXd control_columns(const Eigen::Ref<const Eigen::VectorXd>& y_i,
                                const Eigen::Ref<const Eigen::VectorXd>& y_j,
                                const Eigen::Ref<const Eigen::VectorXd>& l_i,
                                const Eigen::Ref<const Eigen::VectorXd>& l_j);

/// Mean of y_i less its prediction, from the moments of the columns of (i, i); `control_variance` is that of l_i.
ControlledEstimate controlled_mean(const Moments& columns, double control_variance, double confidence);

/// Standard deviation of y_i from the columns of (i, i); `control_variance` is the known one of l_i.
ControlledEstimate controlled_sd(const Moments& columns, double control_variance, double confidence);

/// Covariance of y_i and y_j; `control_covariance` is the known one of l_i and l_j.
ControlledEstimate controlled_covariance(const Moments& columns, double control_covariance, double confidence);

}  // namespace surveymc
