#include "stats/antithetic.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "random/stream.h"
#include "stats/control_variate.h"
#include "stats/tally.h"

using namespace surveymc;
using namespace surveymc::stats;

namespace {

/// Two quantities y = l + c (l^2 - 1) + e l^3 + d w + f (w^2 - 1), with l standard normal (correlated by rho) and w
/// another normal.
constexpr double kCurve = 0.1, kCubic = 0.01, kOther = 0.05, kBow = 0.03, kRho = 0.6;
// cov(l0^2, l1^2) = 2 rho^2, cov(l0, l1^3) = 3 rho, cov(l0^3, l1^3) = 9 rho + 6 rho^3
constexpr double covariance_of(double rho) {
  return rho + 2 * kCurve * kCurve * rho * rho + 6 * kCubic * rho + kCubic * kCubic * (9 * rho + 6 * rho * rho * rho);
}
const double kSd = std::sqrt(covariance_of(1) + kOther * kOther + 2 * kBow * kBow);
const double kCovariance = covariance_of(kRho);

struct Sample {
  Eigen::MatrixXd y, l;  // n x 2
};
Sample sample(int n, std::uint64_t seed, bool antithetic) {
  Sample s{Eigen::MatrixXd(n, 2), Eigen::MatrixXd(n, 2)};
  const random::Stream stream(seed, 98);
  for (int t = 0; t < n; ++t) {
    auto z = stream.normals<double>(static_cast<std::uint64_t>(antithetic ? t / 2 : t),
                                    random::Channel::magnetometer_noise, 0);
    if (antithetic && t % 2 == 1)
      for (double& v : z) v = -v;
    const double l[2] = {z[0], kRho * z[0] + 0.8 * z[1]};
    for (int i = 0; i < 2; ++i) {
      s.l(t, i) = l[i];
      const double w = z[static_cast<std::size_t>(2 + i)];
      s.y(t, i) = l[i] + kCurve * (l[i] * l[i] - 1) + kCubic * l[i] * l[i] * l[i] + kOther * w + kBow * (w * w - 1);
    }
  }
  return s;
}

Eigen::MatrixXd columns(const Sample& s, int i, int j) {
  return control_columns(s.y.col(i), s.y.col(j), s.l.col(i), s.l.col(j));
}

/// Mean and mean square of an estimate's error over repetitions.
struct Errors {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double e) {
    sum += e;
    squares += e * e;
    ++count;
  }
  double in_standard_errors() const { return sum / std::sqrt(squares); }
  double mean_square() const { return squares / count; }
};

bool holds(const Interval& i, double x) { return i.lo <= x && x <= i.hi; }

}  // namespace

TEST_CASE("Estimates from antithetic pairs are unbiased and their 95 % intervals hold the truth", "[long]") {
  constexpr int repetitions = 600, n = 16000;
  int mean = 0, sd = 0, controlled_means = 0, controlled_sds = 0, covariances = 0, plain_sds = 0;
  Errors of_mean, of_variance, of_covariance, of_controlled, of_controlled_covariance, independent,
      independent_covariance;
  double reduction = 0, reduction_of_covariance = 0;
  for (int rep = 0; rep < repetitions; ++rep) {
    const Sample s = sample(n, 5000 + static_cast<std::uint64_t>(rep), true);
    const Moments trials = Moments::of(s.y), pairs = Moments::of(pair_columns(s.y));
    const SampleSummary summary = summarise_pairs(trials, pairs, 0);
    mean += holds(mean_interval(summary, 0.95), 0.0);
    sd += holds(sd_interval(summary, 0.95), kSd);
    of_mean.add(summary.mean);
    of_variance.add(summary.variance - kSd * kSd);
    of_covariance.add(paired_covariance(trials, pairs)(0, 1) - kCovariance);

    const Eigen::MatrixXd x00 = columns(s, 0, 0), x01 = columns(s, 0, 1);
    const Moments m00 = Moments::of(x00), m01 = Moments::of(x01), p00 = Moments::of(pair_means(x00)),
                  p01 = Moments::of(pair_means(x01));
    const ControlledEstimate e = controlled_sd(m00, 1, 0.95, &p00), c = controlled_covariance(m01, kRho, 0.95, &p01);
    controlled_means += holds(controlled_mean(m00, 1, 0.95, &p00).controlled_interval, 0);
    controlled_sds += holds(e.controlled_interval, kSd);
    plain_sds += holds(e.plain_interval, kSd);
    covariances += holds(c.controlled_interval, kCovariance);
    of_controlled.add(e.controlled - kSd);
    of_controlled_covariance.add(c.controlled - kCovariance);
    reduction += e.variance_reduction / repetitions;
    reduction_of_covariance += c.variance_reduction / repetitions;

    const Moments other = Moments::of(sample(n, 9000 + static_cast<std::uint64_t>(rep), false).y);
    independent.add(std::sqrt(other.variance(0)) - kSd);
    independent_covariance.add(other.covariance()(0, 1) - kCovariance);
  }
  // 4 standard errors of a share of 0.95. 8000 pairs, because what the control leaves is of fourth order and has heavy
  // tails: with 500 pairs the interval of the controlled sd holds 90 %.
  for (const int hits : {mean, sd, controlled_means, controlled_sds, plain_sds, covariances})
    CHECK(std::abs(hits / double(repetitions) - 0.95) < 0.0356);
  for (const Errors& e : {of_mean, of_variance, of_covariance, of_controlled, of_controlled_covariance})
    CHECK(std::abs(e.in_standard_errors()) < 4);
  // The claimed reduction is that against independent trials, as repetitions show it: a ratio of two mean squares,
  // each known to sqrt(2 / 600) = 5.8 %; four standard errors of the ratio.
  CHECK(independent.mean_square() / of_controlled.mean_square() == Approx(reduction).epsilon(0.33));
  CHECK(independent_covariance.mean_square() / of_controlled_covariance.mean_square() ==
        Approx(reduction_of_covariance).epsilon(0.33));
  CHECK(reduction > 40);
}

TEST_CASE("Half-sums and half-differences make up the covariance of pairs") {
  const int n = 400, p = n / 2;
  const Sample s = sample(n, 3, true);
  const Eigen::MatrixXd h = pair_means(s.y);
  Eigen::MatrixXd d(p, 2);
  for (int j = 0; j < p; ++j) d.row(j) = (s.y.row(2 * j) - s.y.row(2 * j + 1)) / 2;
  const Eigen::MatrixXd centred = h.rowwise() - h.colwise().mean();
  const Eigen::MatrixXd expected = centred.transpose() * centred / (p - 1) + d.transpose() * d / p;
  const Moments trials = Moments::of(s.y), pairs = Moments::of(pair_columns(s.y));
  CHECK((paired_covariance(trials, pairs) - expected).norm() < 1e-13);
  for (int i = 0; i < 2; ++i) {
    const SampleSummary one = summarise_pairs(trials, pairs, i);
    CHECK(one.units == p);
    CHECK(one.variance == Approx(expected(i, i)).epsilon(1e-13));
    CHECK(one.unit_variance == Approx(centred.col(i).squaredNorm() / (p - 1)).epsilon(1e-12));
    const Eigen::VectorXd u = d.col(i).cwiseAbs2() + centred.col(i).cwiseAbs2();
    const double of_u = (u.array() - u.mean()).square().sum() / (p - 1);
    CHECK(one.unit_kurtosis == Approx(1 + of_u / (one.variance * one.variance)).epsilon(1e-12));
  }
}

TEST_CASE("A linear quantity has no uncertainty of the mean in pairs, and one chi-squared degree a pair") {
  Sample s = sample(2000, 4, true);
  const Moments trials = Moments::of(s.l), pairs = Moments::of(pair_columns(s.l));
  const SampleSummary one = summarise_pairs(trials, pairs, 0);
  CHECK(one.mean == 0);
  CHECK(one.unit_variance == 0);
  CHECK(one.variance == Approx(s.l.col(0).squaredNorm() / 2000).epsilon(1e-14));
  // Standard normal: 4 standard errors of a kurtosis from 1000 values, and sd to 4 / sqrt(2 * 1000)
  CHECK(std::abs(one.unit_kurtosis - 3) < 4 * std::sqrt(24.0 / 1000));
  CHECK(std::abs(std::sqrt(one.variance) - 1) < 4 / std::sqrt(2000.0));
}

TEST_CASE("Pairs that do not depend on each other are worth as much as trials") {
  // Same standard errors: unit_variance / pairs of the mean, (unit_kurtosis - 1) / pairs of the relative variance.
  const Sample s = sample(200000, 6, false);
  const Moments trials = Moments::of(s.y), pairs = Moments::of(pair_columns(s.y));
  const SampleSummary a = summarise(trials, 0), b = summarise_pairs(trials, pairs, 0);
  CHECK(b.mean == Approx(a.mean).margin(1e-14));
  CHECK(b.variance ==
        Approx(a.variance).epsilon(1e-4));  // 1 / pairs = 1e-5, times what the pairs' correlation is short of 0
  CHECK(2 * b.unit_variance == Approx(a.unit_variance).epsilon(4 * std::sqrt(2.0 / 100000)));
  CHECK(2 * (b.unit_kurtosis - 1) == Approx(a.unit_kurtosis - 1).epsilon(0.05));  // eighth moments of 1e5 values
}

TEST_CASE("The interval of a share from pairs holds it, alike or independent as they may be") {
  constexpr int repetitions = 2000, pairs = 300;
  for (const bool alike : {true, false})
    for (const double probability : {0.02, 0.4}) {
      int hits = 0;
      for (int rep = 0; rep < repetitions; ++rep) {
        const random::Stream stream(static_cast<std::uint64_t>(rep), 97);
        std::uint64_t inside = 0;
        for (int t = 0; t < 2 * pairs; ++t) {
          const auto address = static_cast<std::uint64_t>(alike ? t / 2 : t);
          inside += stream.uniforms<double>(address, random::Channel::magnetometer_noise, 0)[0] < probability;
        }
        hits += holds(paired_binomial_interval(inside, pairs, 0.95), probability);
      }
      CHECK(hits / double(repetitions) > 0.95 - 4 * std::sqrt(0.95 * 0.05 / repetitions));
    }
  CHECK(paired_binomial_interval(600, 300, 0.95).hi == 1);
  CHECK(paired_binomial_interval(0, 300, 0.95).lo == 0);
  CHECK(paired_binomial_interval(7, 300, 0.95).lo == binomial_interval(3, 300, 0.95).lo);
  CHECK(paired_binomial_interval(7, 300, 0.95).hi == binomial_interval(4, 300, 0.95).hi);
}

TEST_CASE("Tallies of pairs merge") {
  const Sample s = sample(600, 8, true);
  const auto tally = [&](int first, int count) -> Tally {
    const Eigen::MatrixXd y = s.y.middleRows(first, count);
    return {.trials = static_cast<std::uint64_t>(count),
            .left_out = 3,
            .moments = Moments::of(y),
            .pairs = Moments::of(pair_columns(y)),
            .controlled_pairs = {Moments::of(pair_means(y))}};
  };
  Tally merged;
  merged.merge(tally(0, 400));
  merged.merge(tally(400, 200));
  const Tally whole = tally(0, 600);
  CHECK(merged.left_out == 6);
  CHECK(merged.pairs.count == 300);
  const SampleSummary a = summarise_pairs(merged.moments, merged.pairs, 1),
                      b = summarise_pairs(whole.moments, whole.pairs, 1);
  CHECK(a.variance == Approx(b.variance).epsilon(1e-13));
  CHECK(a.unit_kurtosis == Approx(b.unit_kurtosis).epsilon(1e-12));
  CHECK(merged.controlled_pairs[0].variance(0) == Approx(whole.controlled_pairs[0].variance(0)).epsilon(1e-13));
}
