#include "stats/control_variate.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "random/stream.h"

using namespace surveymc;

namespace {

/// A slightly nonlinear model: y = l + c (l^2 - 1) + d w, with l, w standard normal; two of them, correlated by 0.6.
struct Sample {
  Eigen::VectorXd y0, y1, l0, l1;
};
constexpr double kCurve = 0.1, kOther = 0.05, kCorrelation = 0.6;
Sample sample(int n, std::uint64_t seed) {
  Sample s{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  const Stream stream(seed, 98);
  for (int t = 0; t < n; ++t) {
    const auto z = stream.normals<double>(static_cast<std::uint64_t>(t), Channel::magnetometer_noise, 0);
    s.l0[t] = z[0];
    s.l1[t] = kCorrelation * z[0] + 0.8 * z[1];
    s.y0[t] = s.l0[t] + kCurve * (s.l0[t] * s.l0[t] - 1) + kOther * z[2];
    s.y1[t] = s.l1[t] + kCurve * (s.l1[t] * s.l1[t] - 1) + kOther * z[3];
  }
  return s;
}
// var(l^2 - 1) = 2, cov(l0^2, l1^2) = 2 rho^2
const double kSd = std::sqrt(1 + 2 * kCurve * kCurve + kOther * kOther);
const double kCovariance = kCorrelation + kCurve * kCurve * 2 * kCorrelation * kCorrelation;

}  // namespace

TEST_CASE("Controlled estimates are unbiased, their 95 % intervals hold the truth, and they are narrower") {
  constexpr int repetitions = 1500, n = 1000;
  int mean = 0, sd = 0, covariance = 0, plain_sd = 0;
  double squared = 0, plain_squared = 0, reduction = 0;
  for (int rep = 0; rep < repetitions; ++rep) {
    const Sample s = sample(n, 100 + static_cast<std::uint64_t>(rep));
    const Moments m00 = Moments::of(control_columns(s.y0, s.y0, s.l0, s.l0));
    const Moments m01 = Moments::of(control_columns(s.y0, s.y1, s.l0, s.l1));
    const auto holds = [](const Interval& i, double x) { return i.lo <= x && x <= i.hi; };
    const ControlledEstimate e = controlled_sd(m00, 1, 0.95);
    mean += holds(controlled_mean(m00, 1, 0.95).controlled_interval, 0);
    sd += holds(e.controlled_interval, kSd);
    plain_sd += holds(e.plain_interval, kSd);
    covariance += holds(controlled_covariance(m01, kCorrelation, 0.95).controlled_interval, kCovariance);
    squared += (e.controlled - kSd) * (e.controlled - kSd);
    plain_squared += (e.plain - kSd) * (e.plain - kSd);
    reduction += e.variance_reduction / repetitions;
  }
  // 4 standard errors of a share of .95 (0.0225), and .5 % for n = 1000 not being infinite
  for (const int hits : {mean, sd, covariance, plain_sd}) CHECK(std::abs(hits / double(repetitions) - 0.95) < 0.0275);
  // The claimed reduction is the one that repetitions show: ratio of two mean squares, 4 standard errors of each.
  CHECK(plain_squared / squared == Approx(reduction).epsilon(0.3));
  CHECK(reduction > 10);
}

TEST_CASE("A perfect control leaves no uncertainty; one that does not vary changes nothing") {
  const Sample s = sample(300, 5);
  const Moments perfect = Moments::of(control_columns(s.l0, s.l0, s.l0, s.l0));
  const ControlledEstimate e = controlled_sd(perfect, 1, 0.95);
  CHECK(e.controlled == Approx(1).epsilon(1e-6));  // the regression's rounding
  CHECK(e.variance_reduction > 1e6);
  CHECK(std::abs(controlled_mean(perfect, 1, 0.95).controlled) < 1e-9);

  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(300);
  const ControlledEstimate none = controlled_sd(Moments::of(control_columns(s.y0, s.y0, zero, zero)), 0, 0.95);
  CHECK(none.controlled == none.plain);
  CHECK(none.variance_reduction == 1);
}
