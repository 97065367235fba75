#include "stats/control_variate.h"

#include <cmath>
#include <vector>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "random/stream.h"
#include "stats/antithetic.h"

using namespace surveymc;
using namespace surveymc::stats;

namespace {

/// A slightly nonlinear model: y = l + c (l^2 - 1) + d w, with l, w standard normal; two of them, correlated by 0.6.
struct Sample {
  Eigen::VectorXd y0, y1, l0, l1;
};
constexpr double kCurve = 0.1, kOther = 0.05, kCorrelation = 0.6;
Sample sample(int n, std::uint64_t seed) {
  Sample s{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  const random::Stream stream(seed, 98);
  for (int t = 0; t < n; ++t) {
    const auto z = stream.normals<double>(static_cast<std::uint64_t>(t), random::Channel::magnetometer_noise, 0);
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

bool holds(const Interval& i, double x) { return i.lo <= x && x <= i.hi; }

}  // namespace

TEST_CASE("Controlled estimates are unbiased, their 95 % intervals hold the truth, and they are narrower", "[long]") {
  constexpr int repetitions = 1500, n = 1000;
  int mean = 0, sd = 0, covariance = 0, plain_sd = 0;
  double squared = 0, plain_squared = 0, reduction = 0;
  for (int rep = 0; rep < repetitions; ++rep) {
    const Sample s = sample(n, 100 + static_cast<std::uint64_t>(rep));
    const Moments m00 = Moments::of(control_columns(s.y0, s.y0, s.l0, s.l0));
    const Moments m01 = Moments::of(control_columns(s.y0, s.y1, s.l0, s.l1));
    const ControlledEstimate e = controlled_sd(m00, 1, 0.95);
    mean += holds(controlled_mean(m00, 1, 0.95).controlled_interval, 0);
    sd += holds(e.controlled_interval, kSd);
    plain_sd += holds(e.plain_interval, kSd);
    covariance += holds(controlled_covariance(m01, kCorrelation, 0.95).controlled_interval, kCovariance);
    squared += (e.controlled - kSd) * (e.controlled - kSd);
    plain_squared += (e.plain - kSd) * (e.plain - kSd);
    reduction += e.variance_reduction / repetitions;
  }
  // 4 standard errors of a share of 0.95 (0.0225), and 0.5 % for n = 1000 not being infinite
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

  // What is left of a linear estimator is rounding, some 2e-16 of the variance: its interval is narrow, holds the
  // truth, and has a width.
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Sample x = sample(300, seed);
    const Eigen::VectorXd linear = 3 * x.l0;
    const Moments m = Moments::of(control_columns(linear, linear, x.l0, x.l0));
    for (const auto& [found, truth] :
         {std::pair(controlled_mean(m, 1, 0.95), 0.0), std::pair(controlled_sd(m, 1, 0.95), 3.0)}) {
      CHECK(found.variance_reduction > 1e12);
      CHECK(found.variance_reduction < 1e17);
      CHECK(found.controlled_interval.lo < truth);
      CHECK(truth < found.controlled_interval.hi);
      CHECK(found.controlled_interval.hi - found.controlled_interval.lo < 1e-7);
    }
  }

  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(300);
  const ControlledEstimate none = controlled_sd(Moments::of(control_columns(s.y0, s.y0, zero, zero)), 0, 0.95);
  CHECK(none.controlled == none.plain);
  CHECK(none.variance_reduction == 1);
}

namespace {

/// What failure leaves of the toy model: mean and sd of y0 where |l0 + shift| < limit, by quadrature over l0.
struct Truncated {
  double mean, sd;
};
Truncated truncated(double limit, bool two_sided) {
  double weight = 0, first = 0, second = 0;
  for (double l = -9; l < 9; l += 1e-4) {
    if (l > limit || (two_sided && l < -limit)) continue;
    const double w = std::exp(-l * l / 2), y = l + kCurve * (l * l - 1);
    weight += w;
    first += w * y;
    second += w * (y * y + kOther * kOther);
  }
  return {first / weight, std::sqrt(second / weight - first * first / (weight * weight))};
}

}  // namespace

TEST_CASE("Trials that fail are accounted for: of those that do not, means and sds are right, and still narrower",
          "[long]") {
  constexpr int repetitions = 1500, n = 1000;
  constexpr double limit = 1.5;  // trials with l0 above it fail: 6.7 %
  const Truncated truth = truncated(limit, false);
  int mean = 0, sd = 0, ignored = 0;
  double reduction = 0;
  for (int rep = 0; rep < repetitions; ++rep) {
    const Sample s = sample(n, 100 + static_cast<std::uint64_t>(rep));
    std::vector<int> kept, failed;
    for (int t = 0; t < n; ++t) (s.l0[t] > limit ? failed : kept).push_back(t);
    const Eigen::VectorXd y = s.y0(kept), l = s.l0(kept), of_failed = s.l0(failed);
    const Moments m = Moments::of(control_columns(y, y, l, l)), lost = Moments::of(lost_columns(of_failed, of_failed));
    const ControlledEstimate of_mean = controlled_mean(m, 1, 0.95, nullptr, {&lost, nullptr});
    mean += holds(of_mean.controlled_interval, truth.mean);
    sd += holds(controlled_sd(m, 1, 0.95, nullptr, {&lost, nullptr}).controlled_interval, truth.sd);
    ignored += holds(controlled_mean(m, 1, 0.95).controlled_interval, truth.mean);
    CHECK(std::abs(of_mean.plain - y.mean()) < 1e-13);  // two orders of one sum of 1000 terms below 10
    reduction += of_mean.variance_reduction / repetitions;
  }
  // 4 standard errors of a share of 0.95 (0.0225), and 0.5 % for n = 1000 not being infinite
  for (const int hits : {mean, sd}) CHECK(std::abs(hits / double(repetitions) - 0.95) < 0.0275);
  CHECK(reduction > 2);
  CHECK(ignored < repetitions / 10);  // the control's mean over all trials is not that of the trials that are left
}

TEST_CASE("Pairs with a failed trial are accounted for", "[long]") {
  constexpr int repetitions = 600, pairs = 1500;
  constexpr double limit = 2;  // either trial of a pair beyond it fails: 4.6 % of pairs are left out
  const Truncated truth = truncated(limit, true);
  int mean = 0, sd = 0;
  for (int rep = 0; rep < repetitions; ++rep) {
    const Sample s = sample(pairs, 7000 + static_cast<std::uint64_t>(rep));
    std::vector<double> y, l, of_lost;
    for (int t = 0; t < pairs; ++t)
      for (const double sign : {1.0, -1.0}) {
        const double l0 = sign * s.l0[t], other = sign * (s.y0[t] - s.l0[t] - kCurve * (s.l0[t] * s.l0[t] - 1));
        if (std::abs(l0) > limit) {
          of_lost.push_back(l0);
          continue;
        }
        l.push_back(l0);
        y.push_back(l0 + kCurve * (l0 * l0 - 1) + other);
      }
    const auto vector = [](const std::vector<double>& v) {
      return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size())));
    };
    const Eigen::MatrixXd columns = control_columns(vector(y), vector(y), vector(l), vector(l)),
                          lost_of = lost_columns(vector(of_lost), vector(of_lost));
    const Moments trials = Moments::of(columns), in_pairs = Moments::of(pair_means(columns)),
                  lost = Moments::of(lost_of), lost_pairs = Moments::of(pair_means(lost_of));
    mean += holds(controlled_mean(trials, 1, 0.95, &in_pairs, {&lost, &lost_pairs}).controlled_interval, truth.mean);
    sd += holds(controlled_sd(trials, 1, 0.95, &in_pairs, {&lost, &lost_pairs}).controlled_interval, truth.sd);
  }
  // 4 standard errors of a share of 0.95 (0.036), and 2 % for heavy tails with few pairs (control_variate.h)
  for (const int hits : {mean, sd}) CHECK(std::abs(hits / double(repetitions) - 0.95) < 0.056);
}

TEST_CASE("Intervals of controlled sds from few pairs hold the truth, although what the control leaves has heavy tails",
          "[long]") {
  constexpr int repetitions = 3000;
  // y = l + c (l^2 - 1): a pair leaves c^2 He4(l). By normal quantiles: 0.82, 0.88, 0.92 at 95 %.
  const double sd = std::sqrt(1 + 2 * kCurve * kCurve);
  for (const int pairs : {200, 500, 1500}) {
    CAPTURE(pairs);
    int held = 0, held_99 = 0, held_mean = 0;
    for (int rep = 0; rep < repetitions; ++rep) {
      const Sample s = sample(pairs, 20000 + static_cast<std::uint64_t>(rep));
      Eigen::VectorXd y(2 * pairs), l(2 * pairs);
      for (int t = 0; t < pairs; ++t)
        for (int side = 0; side < 2; ++side) {
          l[2 * t + side] = side == 0 ? s.l0[t] : -s.l0[t];
          y[2 * t + side] = l[2 * t + side] + kCurve * (s.l0[t] * s.l0[t] - 1);
        }
      const Eigen::MatrixXd columns = control_columns(y, y, l, l);
      const Moments trials = Moments::of(columns), in_pairs = Moments::of(pair_means(columns));
      held += holds(controlled_sd(trials, 1, 0.95, &in_pairs).controlled_interval, sd);
      held_99 += holds(controlled_sd(trials, 1, 0.99, &in_pairs).controlled_interval, sd);
      held_mean += holds(controlled_mean(trials, 1, 0.95, &in_pairs).controlled_interval, 0);
    }
    // 4 standard errors of a share of 0.95 (0.016) and of 0.99 (0.0073), and what 8 % of the quantile are: 0.009 and
    // 0.003
    CHECK(std::abs(held / double(repetitions) - 0.95) < 0.025);
    CHECK(std::abs(held_99 / double(repetitions) - 0.99) < 0.0103);
    CHECK(held_mean > 0.9 * repetitions);
  }
}
