#include "monitoring/metrics.h"

#include <cmath>

#include "base/units.h"

namespace surveymc::monitoring {

void MeanSquareError::add(const Samples& predicted, const Samples& target) {
  sum_ += (predicted - target).array().square().colwise().sum().matrix();
  rows_ += predicted.rows();
}

void Sensitivities::add(const Samples& with_drift, const Samples& without, const Samples& drift) {
  const Samples change = (with_drift - without).cwiseAbs();
  for (Eigen::Index k = 0; k < drift.cols(); ++k)
    for (Eigen::Index i = 0; i < drift.rows(); ++i) {
      if (drift(i, k) == 0) continue;
      rows_[k] += 1;
      sum_.col(k) += change.row(i).transpose() / std::abs(drift(i, k));
    }
}

Eigen::RowVectorXd mean_square_error(const Samples& predicted, const Samples& target) {
  MeanSquareError e(predicted.cols());
  e.add(predicted, target);
  return e.value();
}

Eigen::MatrixXd sensitivities(const Samples& with_drift, const Samples& without, const Samples& drift) {
  Sensitivities s(drift.cols());
  s.add(with_drift, without, drift);
  return s.value();
}

namespace {

template <class Wanted>
double mean_where(const Eigen::MatrixXd& s, Wanted wanted) {
  double sum = 0;
  int count = 0;
  for (Eigen::Index k = 0; k < s.cols(); ++k)
    for (Eigen::Index j = 0; j < s.rows(); ++j)
      if (!std::isnan(s(k, k)) && wanted(j, k)) {
        sum += s(j, k);
        ++count;
      }
  return count > 0 ? sum / count : kNaN;
}

}  // namespace

double mean_auto_sensitivity(const Eigen::MatrixXd& s) {
  return mean_where(s, [](Eigen::Index j, Eigen::Index k) { return j == k; });
}

double mean_cross_sensitivity(const Eigen::MatrixXd& s) {
  return mean_where(s, [&](Eigen::Index j, Eigen::Index) { return std::isnan(s(j, j)); });
}

}  // namespace surveymc::monitoring
