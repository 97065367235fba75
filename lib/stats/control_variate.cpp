#include "stats/control_variate.h"

#include <cmath>

#include "stats/linear_algebra.h"

namespace surveymc {
namespace {

enum { kYi, kYj, kLi, kLj, kYY, kLL, kColumns };
using Combination = Eigen::Matrix<double, kColumns, 1>;  // coefficients of the six columns
constexpr std::array<int, 3> kControls{kLi, kLj, kLL};

/// An estimate, the per-trial terms that its first-order error is the mean of, and their variance over the count.
struct Estimate {
  double value;
  Combination influence;
  double variance;
};

double variance_of_mean(const Moments& m, const Combination& c) {
  return c.dot(m.squares * c) / (static_cast<double>(m.count) - 1) / static_cast<double>(m.count);
}

/// `plain` less its regression on the controls, whose means are 0, 0 and control_covariance.
Estimate with_controls(const Moments& m, const Estimate& plain, double control_covariance) {
  Eigen::MatrixXd among(3, 3);
  Eigen::VectorXd with_plain(3), excess(3), scale(3);
  for (int a = 0; a < 3; ++a) {
    const int i = kControls[static_cast<std::size_t>(a)];
    // A control that does not vary (a direction that noise does not reach to first order) gets no weight.
    scale[a] = m.squares(i, i) > 0 ? 1 / std::sqrt(m.squares(i, i)) : 0;
    excess[a] = m.mean[i] - (i == kLL ? control_covariance : 0);
    with_plain[a] = m.squares.row(i).dot(plain.influence) * scale[a];
  }
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      among(a, b) = m.squares(kControls[static_cast<std::size_t>(a)], kControls[static_cast<std::size_t>(b)]) *
                    scale[a] * scale[b];
  // l_i and l_j are one for i = j: the solution of least norm shares the weight between them.
  const Eigen::VectorXd weight = scale.cwiseProduct(least_squares_solution(among, with_plain, 1e-9));
  Estimate e = plain;
  e.value -= weight.dot(excess);
  for (int a = 0; a < 3; ++a) e.influence[kControls[static_cast<std::size_t>(a)]] -= weight[a];
  e.variance = variance_of_mean(m, e.influence);
  return e;
}

/// Mean of y_i or y_j.
Estimate mean_estimate(const Moments& m, int component) {
  Estimate e{m.mean[component], Combination::Zero(), 0};
  e.influence[component] = 1;
  e.variance = variance_of_mean(m, e.influence);
  return e;
}

/// E[y_i y_j] - mean_i mean_j, linearised about these means: of y_i y_j - mean_j y_i - mean_i y_j only the mean is
/// estimated. With the controlled means what is neglected is their error squared, and not that of the sample's.
Estimate covariance_estimate(const Moments& m, double mean_i, double mean_j) {
  Estimate e{m.mean[kYY] - mean_j * m.mean[kYi] - mean_i * m.mean[kYj] + mean_i * mean_j, Combination::Zero(), 0};
  e.influence[kYY] = 1;
  e.influence[kYi] -= mean_j;
  e.influence[kYj] -= mean_i;
  e.variance = variance_of_mean(m, e.influence);
  return e;
}

struct Estimates {
  Estimate plain, controlled;
};
Estimates mean_estimates(const Moments& m, double control_variance) {
  const Estimate plain = mean_estimate(m, kYi);
  return {plain, with_controls(m, plain, control_variance)};
}
Estimates covariance_estimates(const Moments& m, double control_covariance) {
  const double i = with_controls(m, mean_estimate(m, kYi), control_covariance).value,
               j = with_controls(m, mean_estimate(m, kYj), control_covariance).value;
  return {covariance_estimate(m, m.mean[kYi], m.mean[kYj]),
          with_controls(m, covariance_estimate(m, i, j), control_covariance)};
}

/// The same terms' variance over independent trials: each trial of a pair by itself has their distribution.
double variance_reduction(const Moments& trials, const Estimates& e) {
  return variance_of_mean(trials, e.plain.influence) / e.controlled.variance;
}

Interval around(const Estimate& e, double confidence) {
  const double half = normal_quantile(1 - (1 - confidence) / 2) * std::sqrt(e.variance);
  return {e.value - half, e.value + half};
}

/// Of the standard deviation, from an estimate of the variance: symmetric in the logarithm, so that it stays positive.
Interval around_root(const Estimate& e, double confidence) {
  const double factor = std::exp(normal_quantile(1 - (1 - confidence) / 2) * std::sqrt(e.variance) / (2 * e.value));
  return {std::sqrt(e.value) / factor, std::sqrt(e.value) * factor};
}

}  // namespace

Eigen::MatrixXd control_columns(const Eigen::Ref<const Eigen::VectorXd>& y_i,
                                const Eigen::Ref<const Eigen::VectorXd>& y_j,
                                const Eigen::Ref<const Eigen::VectorXd>& l_i,
                                const Eigen::Ref<const Eigen::VectorXd>& l_j) {
  Eigen::MatrixXd x(y_i.size(), static_cast<Eigen::Index>(kColumns));
  x.col(kYi) = y_i;
  x.col(kYj) = y_j;
  x.col(kLi) = l_i;
  x.col(kLj) = l_j;
  x.col(kYY) = y_i.cwiseProduct(y_j);
  x.col(kLL) = l_i.cwiseProduct(l_j);
  return x;
}

ControlledEstimate controlled_mean(const Moments& trials, double control_variance, double confidence,
                                   const Moments* pairs) {
  const Estimates e = mean_estimates(pairs ? *pairs : trials, control_variance);
  return {e.plain.value, e.controlled.value, around(e.plain, confidence), around(e.controlled, confidence),
          variance_reduction(trials, e)};
}

ControlledEstimate controlled_covariance(const Moments& trials, double control_covariance, double confidence,
                                         const Moments* pairs) {
  const Estimates e = covariance_estimates(pairs ? *pairs : trials, control_covariance);
  return {e.plain.value, e.controlled.value, around(e.plain, confidence), around(e.controlled, confidence),
          variance_reduction(trials, e)};
}

ControlledEstimate controlled_sd(const Moments& trials, double control_variance, double confidence,
                                 const Moments* pairs) {
  const Estimates e = covariance_estimates(pairs ? *pairs : trials, control_variance);
  return {std::sqrt(e.plain.value), std::sqrt(e.controlled.value), around_root(e.plain, confidence),
          around_root(e.controlled, confidence), variance_reduction(trials, e)};
}

}  // namespace surveymc
