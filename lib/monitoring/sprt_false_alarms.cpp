#include "monitoring/sprt_false_alarms.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Core>

#include "base/units.h"
#include "stats/normal_tail.h"

namespace surveymc::monitoring {

std::vector<double> sprt_alarm_probability(const SprtOptions& o, double mean, double sd, int samples) {
  const double lower = sprt_lower(o), upper = sprt_upper(o), slope = o.shift / o.variance;
  const double step_mean = slope * (mean - o.shift / 2), step_sd = slope * sd;
  const auto below = [&](double bound, double from) {  // P(from + increment < bound)
    return stats::normal_upper_tail(from + step_mean - bound, step_sd);
  };
  const auto above = [&](double bound, double from) {
    return stats::normal_upper_tail(bound - from - step_mean, step_sd);
  };
  const auto density = [&](double to, double from) {
    const double z = (to - from - step_mean) / step_sd;
    return std::exp(-0.5 * z * z) / (step_sd * std::sqrt(2 * kPi));
  };

  // Three Gauss-Legendre nodes a panel.
  const double half_sds = std::ceil((upper - lower) / (0.5 * step_sd));
  if (!(half_sds <= kMostSprtPanels)) return std::vector<double>(static_cast<std::size_t>(samples), kNaN);
  const int panels = std::max(static_cast<int>(half_sds), 4);
  const double half = (upper - lower) / (2 * panels), off = std::sqrt(0.6) * half;
  Eigen::VectorXd node(3 * panels), weight(3 * panels);
  for (int i = 0; i < panels; ++i) {
    const double middle = lower + (2 * i + 1) * half;
    node.segment<3>(3 * i) << middle - off, middle, middle + off;
    weight.segment<3>(3 * i) << 5 * half / 9, 8 * half / 9, 5 * half / 9;
  }
  const Eigen::Index n = node.size();
  Eigen::MatrixXd kernel(n, n);
  Eigen::VectorXd from_zero(n), to_lower(n), to_upper(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) kernel(i, j) = density(node[i], node[j]) * weight[j];
    from_zero[i] = density(node[i], 0);
    to_lower[i] = weight[i] * below(lower, node[i]);
    to_upper[i] = weight[i] * above(upper, node[i]);
  }
  const double zero_to_lower = below(lower, 0), zero_to_upper = above(upper, 0);

  Eigen::VectorXd f = Eigen::VectorXd::Zero(n);
  double atom = 1, accepted = 0;
  std::vector<double> by_sample;
  for (int i = 0; i < samples; ++i) {
    accepted += atom * zero_to_upper + to_upper.dot(f);
    const double next_atom = atom * zero_to_lower + to_lower.dot(f);
    f = kernel * f + atom * from_zero;
    atom = next_atom;
    by_sample.push_back(accepted);
  }
  return by_sample;
}

TwoSided two_sided_alarm_probability(double p) { return {p * (2 - p), std::min(2 * p, 1.0)}; }

}  // namespace surveymc::monitoring
