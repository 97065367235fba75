#pragma once
/// Accuracy and sensitivity of a monitor (Hines et al. 2008; Boechat, Moreno and Haramura, eqs 12-14).
#include "monitoring/samples.h"

namespace surveymc::monitoring {

/// Mean square difference of every column (eq 12), of rows that come block by block.
class MeanSquareError {
 public:
  explicit MeanSquareError(Eigen::Index sensors) : sum_(Eigen::RowVectorXd::Zero(sensors)) {}
  void add(const Samples& predicted, const Samples& target);
  Eigen::RowVectorXd value() const { return sum_ / static_cast<double>(rows_); }  ///< NaN without rows

 private:
  Eigen::RowVectorXd sum_;
  Eigen::Index rows_ = 0;
};

/// s(j, k): mean of |xhat_j with drift - xhat_j without| / |drift_k| over the samples in which sensor k drifts
/// (eqs 13 and 14 with the samples of zero drift left out: there the quotient does not exist). The diagonal is the
/// auto sensitivity of k, s(j, k) the cross sensitivity of j to k; NaN where k does not drift.
class Sensitivities {
 public:
  explicit Sensitivities(Eigen::Index sensors)
      : sum_(Eigen::MatrixXd::Zero(sensors, sensors)), rows_(Eigen::RowVectorXd::Zero(sensors)) {}
  void add(const Samples& with_drift, const Samples& without, const Samples& drift);
  Eigen::MatrixXd value() const { return (sum_.array().rowwise() / rows_.array()).matrix(); }

 private:
  Eigen::MatrixXd sum_;
  Eigen::RowVectorXd rows_;
};

/// The same of all rows in one go.
Eigen::RowVectorXd mean_square_error(const Samples& predicted, const Samples& target);
Eigen::MatrixXd sensitivities(const Samples& with_drift, const Samples& without, const Samples& drift);

/// Means over the sensors that drift, and over the pairs of a healthy sensor j and a drifting one k. NaN without any.
double mean_auto_sensitivity(const Eigen::MatrixXd& s);
double mean_cross_sensitivity(const Eigen::MatrixXd& s);

}  // namespace surveymc::monitoring
