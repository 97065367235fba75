#pragma once
/// Accuracy and sensitivity of a monitor (Hines et al. 2008; Boechat, Moreno and Haramura, eqs 12-14).
#include "monitoring/samples.h"

namespace surveymc {

/// Mean square difference of every column (eq 12).
Eigen::RowVectorXd mean_square_error(const Samples& predicted, const Samples& target);

/// s(j, k): mean of |xhat_j with drift - xhat_j without| / |drift_k| over the samples in which sensor k drifts
/// (eqs 13 and 14 with the samples of zero drift left out: there the quotient does not exist). The diagonal is the
/// auto sensitivity of k, s(j, k) the cross sensitivity of j to k; NaN where k does not drift.
Eigen::MatrixXd sensitivities(const Samples& with_drift, const Samples& without, const Samples& drift);

/// Means over the sensors that drift, and over the pairs of a healthy sensor j and a drifting one k. NaN without any.
double mean_auto_sensitivity(const Eigen::MatrixXd& s);
double mean_cross_sensitivity(const Eigen::MatrixXd& s);

}  // namespace surveymc
