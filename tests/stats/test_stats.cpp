#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/units.h"
#include "normal_draws.h"
#include "stats/circular_scatter.h"
#include "stats/confidence_sequence.h"
#include "stats/intervals.h"
#include "stats/normal_tail.h"
#include "stats/sample_summary.h"
#include "stats/tally.h"
#include "stats/tests.h"

using namespace surveymc;
using namespace surveymc::stats;

namespace {
Eigen::MatrixXd draws(int dimension, int count, std::uint64_t seed) {
  return test::normal_draws(random::Stream(seed, 99), 0, count, dimension).transpose();
}
}  // namespace

TEST_CASE("Moments are those of the definition, also of data far from zero") {
  Eigen::MatrixXd x = draws(3, 1000, 1);
  x.row(1) = x.row(0).array().square().matrix() + 0.5 * x.row(1);  // skewed and correlated
  x.array() += 1e6;
  const Moments m = Moments::of(x.transpose());
  using V = Eigen::Matrix<long double, 1, Eigen::Dynamic>;
  for (int i = 0; i < 3; ++i) {
    const V v = x.row(i).cast<long double>();
    const long double mean = v.mean();
    const V r = v.array() - mean;
    CHECK(std::abs(m.mean[i] - static_cast<double>(mean)) < 1e-9);
    CHECK(m.variance(i) == Approx(static_cast<double>(r.squaredNorm() / 999)).epsilon(1e-12));
    CHECK(m.cubes[i] == Approx(static_cast<double>(r.array().cube().sum())).epsilon(1e-7).margin(1e-6));
    CHECK(m.fourths[i] == Approx(static_cast<double>(r.array().square().square().sum())).epsilon(1e-8));
  }
  CHECK(m.covariance()(0, 1) == m.covariance()(1, 0));
}

TEST_CASE("Merged moments are those of the whole, however it is cut") {
  const Eigen::MatrixXd x = draws(2, 1001, 2).array().exp().matrix();  // log-normal: all moments at work
  const Moments whole = Moments::of(x.transpose());
  for (const int cut : {0, 1, 500, 1000, 1001}) {
    Moments a = Moments::of(x.leftCols(cut).transpose());
    a.merge(Moments::of(x.rightCols(1001 - cut).transpose()));
    CAPTURE(cut);
    CHECK(a.count == 1001);
    for (int i = 0; i < 2; ++i) {
      CHECK(a.mean[i] == Approx(whole.mean[i]).epsilon(1e-14));
      CHECK(a.variance(i) == Approx(whole.variance(i)).epsilon(1e-13));
      CHECK(a.cubes[i] == Approx(whole.cubes[i]).epsilon(1e-12));
      CHECK(a.fourths[i] == Approx(whole.fourths[i]).epsilon(1e-12));
    }
    CHECK(a.covariance()(0, 1) == Approx(whole.covariance()(0, 1)).margin(1e-14));
  }
}

TEST_CASE("Only tallies of the same quantities can be merged") {
  const auto of = [](Eigen::Index d) { return Moments::of(Eigen::MatrixXd::Ones(4, d)); };
  const Tally a{.moments = of(3),
                .groups = {of(2), of(1)},
                .controlled = {of(4)},
                .pairs = of(2),
                .controlled_pairs = {of(5)},
                .counts = {1, 2}};
  CHECK(can_merge(a, a));
  CHECK(can_merge(a, Tally()));  // a block in which all trials failed
  CHECK(can_merge(Tally(), a));
  const auto changed = [&](auto change) {
    Tally b = a;
    change(b);
    return can_merge(a, b) || can_merge(b, a);
  };
  CHECK_FALSE(changed([&](Tally& b) { b.moments = of(4); }));
  CHECK_FALSE(changed([&](Tally& b) { b.groups[1] = of(2); }));
  CHECK_FALSE(changed([&](Tally& b) { b.controlled[0] = of(3); }));
  CHECK_FALSE(changed([&](Tally& b) { b.pairs = of(3); }));
  CHECK_FALSE(changed([&](Tally& b) { b.controlled_pairs[0] = of(4); }));
  CHECK_FALSE(changed([&](Tally& b) { b.counts.push_back(3); }));
}

TEST_CASE("A tally lists the first thousand failures and keeps samples in order") {
  Tally a, b;
  a.trials = b.trials = 800;
  a.failed = b.failed = 700;
  for (std::uint64_t i = 0; i < 700; ++i) {
    a.failed_trials.push_back(i);
    b.failed_trials.push_back(1000 + i);
  }
  a.samples = {1, 2};
  b.samples = {3};
  b.counts = {4, 5};
  a.merge(b);
  CHECK(a.failed == 1400);
  CHECK(a.failed_trials.size() == Tally::kMaxListed);
  CHECK(a.failed_trials.back() == 1299);
  CHECK(a.samples == std::vector<double>{1, 2, 3});
  CHECK(a.counts == std::vector<std::uint64_t>{4, 5});
}

TEST_CASE("Interval of a standard deviation: 4.4 % at 1000 values, 1.4 % at 10,000") {
  const Interval a = sd_interval(1, 1000, 3, 0.95), b = sd_interval(1, 10000, 3, 0.95);
  CHECK((a.hi - a.lo) / 2 == Approx(0.0439).margin(0.0003));
  CHECK((b.hi - b.lo) / 2 == Approx(0.01386).margin(0.0001));
  CHECK(sd_interval(1, 1000, 9, 0.95).hi > a.hi);     // heavy tails: wider
  CHECK(sd_interval(1, 1000, 1.8, 0.95).hi == a.hi);  // light tails: as normal
  CHECK(sd_interval(4, 1000, 3, 0.95).lo == Approx(2 * a.lo).epsilon(1e-13));
}

TEST_CASE("95 % intervals hold the truth in 95 % of repetitions, for normal and for heavy-tailed values", "[long]") {
  int normal = 0, heavy = 0, mean = 0;
  constexpr int repetitions = 2000, n = 400;
  for (int rep = 0; rep < repetitions; ++rep) {
    const Eigen::MatrixXd z = draws(3, n, 1000 + static_cast<std::uint64_t>(rep));
    const Moments m = Moments::of(z.transpose());
    const Interval ci = sd_interval(m.variance(0), m.count, m.kurtosis(0), 0.95);
    normal += ci.lo < 1 && 1 < ci.hi;
    const Interval mi = mean_interval(m.mean[0], m.variance(0), m.count, 0.95);
    mean += mi.lo < 0 && 0 < mi.hi;
    // product of normals: variance 1, kurtosis 9
    const Moments p = Moments::of((z.row(1).array() * z.row(2).array()).matrix().transpose());
    const Interval hi = sd_interval(p.variance(0), p.count, p.kurtosis(0), 0.95);
    heavy += hi.lo < 1 && 1 < hi.hi;
  }
  const double se = std::sqrt(0.95 * 0.05 / repetitions);
  CHECK(std::abs(normal / double(repetitions) - 0.95) < 4 * se + 0.01);  // kurtosis is estimated: a little conservative
  CHECK(std::abs(mean / double(repetitions) - 0.95) < 4 * se);
  CHECK(heavy / double(repetitions) > 0.89);  // the sample kurtosis runs low at n = 400; chi-squared alone gives 0.67
}

TEST_CASE("The tail of a normal distribution: tabulated probabilities") {
  CHECK(normal_upper_tail(0) == 0.5);
  CHECK(std::abs(normal_upper_tail(1.959963984540054) - 0.025) < 1e-15);  // rounding of a value below 1/4
  CHECK(normal_upper_tail(3, 1.5) == normal_upper_tail(2));
}

TEST_CASE("The difference of two shares of the same trials has an interval where all trials are alike, and it covers") {
  // No trial in which one alone is seen: 1 - (alpha / 4)^(1/n) to both sides
  const Interval none = paired_difference_interval(0, 0, 2, 0.95);
  CHECK(none.hi == Approx(1 - std::pow(0.0125, 0.5)).epsilon(1e-9));
  CHECK(none.lo == Approx(-none.hi).epsilon(1e-12));
  CHECK(paired_difference_interval(7, 2, 20, 0.95).lo == -paired_difference_interval(2, 7, 20, 0.95).hi);
  // Exact coverage: the sum over all outcomes of a multinomial that lie within
  for (const auto& [p, q] : {std::pair(0.02, 0.01), {0.3, 0.1}, {0.5, 0.5}}) {
    constexpr int kTrials = 30;
    double covered = 0;
    for (int a = 0; a <= kTrials; ++a)
      for (int b = 0; a + b <= kTrials; ++b) {
        const int c = kTrials - a - b;
        const double rest = 1 - p - q, log_p = std::lgamma(kTrials + 1) - std::lgamma(a + 1) - std::lgamma(b + 1) -
                                               std::lgamma(c + 1) + a * std::log(p) + b * std::log(q);
        const double chance = c == 0 ? std::exp(log_p) : rest > 0 ? std::exp(log_p + c * std::log(rest)) : 0;
        const Interval i =
            paired_difference_interval(static_cast<std::uint64_t>(a), static_cast<std::uint64_t>(b), kTrials, 0.95);
        if (i.lo <= p - q && p - q <= i.hi) covered += chance;
      }
    CAPTURE(p, q, covered);
    CHECK(covered >= 0.95);
  }
}

TEST_CASE("Clopper-Pearson: tabulated bounds and the ends") {
  const Interval a = binomial_interval(8, 20, 0.95);  // Clopper & Pearson 1934: 0.191, 0.639
  CHECK(a.lo == Approx(0.1912).margin(5e-5));
  CHECK(a.hi == Approx(0.6395).margin(5e-5));
  CHECK(binomial_interval(0, 20, 0.95).lo == 0);
  CHECK(binomial_interval(20, 20, 0.95).hi == 1);
}

TEST_CASE("Wishart test: p is uniform under the null and finds a 2 % error in sigma at 60,000 runs") {
  Eigen::MatrixXd truth(2, 2);
  truth << 4, 1.5, 1.5, 1;
  const Eigen::MatrixXd l = truth.llt().matrixL();
  int below = 0;
  constexpr int repetitions = 1500;
  for (int rep = 0; rep < repetitions; ++rep) {
    const Moments m = Moments::of((l * draws(2, 60, 50000 + static_cast<std::uint64_t>(rep))).transpose());
    below += wishart_test(m.covariance(), truth, m.count).p_value < 0.05;
  }
  CHECK(std::abs(below / double(repetitions) - 0.05) < 4 * std::sqrt(0.05 * 0.95 / repetitions));
  const Moments m = Moments::of((l * draws(2, 60000, 7)).transpose());
  CHECK(wishart_test(m.covariance(), truth, m.count).p_value > 1e-3);
  CHECK(wishart_test(m.covariance(), 1.02 * 1.02 * truth, m.count).p_value < 1e-3);
  CHECK(wishart_test(m.covariance(), Eigen::MatrixXd::Zero(2, 2), m.count).p_value == 0);
}

TEST_CASE("The interval of a mean of squares misses the truth on either side alike, with few trials too") {
  const auto missed = [](int n, int squares, int repetitions) {
    std::pair<double, double> out{0, 0};  // the interval lies below, above
    for (int rep = 0; rep < repetitions; ++rep) {
      const Eigen::MatrixXd z = draws(squares, n, 90000 + static_cast<std::uint64_t>(rep));
      const Moments m = Moments::of(z.cwiseAbs2().colwise().mean().transpose());
      const Interval i = mean_square_interval(m.mean[0], m.variance(0), m.count, 0.95);
      out.first += i.hi < 1;
      out.second += i.lo > 1;
    }
    return std::pair{out.first / repetitions, out.second / repetitions};
  };
  // By mean -+ 1.96 standard errors it lies below in 0.148, 0.096, 0.070 of the cases, above in 0.006, 0.013, 0.008.
  for (const auto& [n, squares] : {std::pair{12, 1}, {12, 3}, {60, 1}}) {
    const auto [below, above] = missed(n, squares, 4000);
    CHECK(below < 0.05);
    CHECK(above < 0.045);
    CHECK(below + above > 0.03);
    CHECK(std::abs(below - above) < 0.02);
  }
  CHECK(mean_square_interval(2, 0, 10, 0.95).hi == 2);
  CHECK(mean_square_interval(0, 0, 10, 0.95).lo == 0);
  CHECK(std::isinf(mean_square_interval(1, 100, 2, 0.95).hi));  // two squares, all but one of which may be 0
  // On either side of where all is normal.
  const Interval chi = mean_square_interval(1, 1e-3, 499'000, 0.95),
                 normal = mean_square_interval(1, 1e-3, 501'000, 0.95);
  CHECK(chi.hi - 1 == Approx((normal.hi - 1) * std::sqrt(501.0 / 499)).epsilon(1e-4));
  CHECK(1 - chi.lo == Approx((1 - normal.lo) * std::sqrt(501.0 / 499)).epsilon(1e-4));
}

TEST_CASE("The interval of a mean holds the truth in 95 % of repetitions, of two to five values too") {
  constexpr int repetitions = 4000;
  for (const int n : {2, 3, 5, 30}) {
    CAPTURE(n);
    const Eigen::MatrixXd z = draws(repetitions, n, 77);
    int held = 0;
    for (int rep = 0; rep < repetitions; ++rep) {
      const Moments m = Moments::of(z.row(rep).transpose());
      const Interval ci = mean_interval(m.mean[0], m.variance(0), m.count, 0.95);
      held += ci.lo < 0 && 0 < ci.hi;
    }
    // By the normal distribution: 0.70, 0.81, 0.88 and 0.940.
    CHECK(std::abs(held / double(repetitions) - 0.95) < 4 * std::sqrt(0.95 * 0.05 / repetitions));
  }
}

TEST_CASE("The interval of the sd of both directions holds the truth in 95 % of repetitions", "[long]") {
  constexpr int repetitions = 1000, n = 200;
  for (const bool varies : {false, true}) {
    CAPTURE(varies);
    int held = 0;
    for (int rep = 0; rep < repetitions; ++rep) {
      const Eigen::MatrixXd z = draws(4, n, 5000 + static_cast<std::uint64_t>(rep));
      // A variance that is exponentially distributed over runs, with mean 1, or the same for all.
      Eigen::MatrixXd x(n, 3);
      for (Eigen::Index t = 0; t < n; ++t) {
        x(t, 2) = varies ? (z(2, t) * z(2, t) + z(3, t) * z(3, t)) / 2 : 1;
        for (Eigen::Index a = 0; a < 2; ++a) x(t, a) = std::sqrt(x(t, 2)) * z(a, t);
      }
      const Moments m = Moments::of(x);
      const CircularScatter s{m.count,       m.variance(0), m.variance(1),
                              m.kurtosis(0), m.kurtosis(1), varies ? m.variance(2) : 0};
      const Interval ci = circular_sd_interval(s, 0.95);
      held += ci.lo < 1 && 1 < ci.hi;
    }
    // By the interval of one direction: 0.99 of both. The sample kurtosis runs a little low: 0.94 where it varies.
    CHECK(std::abs(held / double(repetitions) - 0.95) < 4 * std::sqrt(0.95 * 0.05 / repetitions));
  }
  // Normal points: as many degrees as of one direction with twice the values.
  const CircularScatter normal{1000, 1, 1, 3, 3, 0};
  CHECK(circular_sd_interval(normal, 0.95).hi == Approx(sd_interval(1, 1999, 3, 0.95).hi).epsilon(1e-12));
  const SampleSummary one{1000, 0, 1, 1, 3, 0, 3};
  CHECK(std::log(circular_sd_sequence(normal, 0.95).hi) ==
        Approx(std::log(sd_sequence(one, 0.95).hi) / std::sqrt(2.0)).epsilon(1e-12));
}

TEST_CASE("A statistic that could not be computed has no p-value") {
  CHECK(std::isnan(student_upper_tail(3, kNaN)));
  CHECK(std::isnan(chi_squared_upper_tail(3, kNaN)));
  CHECK(chi_squared_upper_tail(3, kInfinity) == 0);
  CHECK(chi_squared_upper_tail(3, -kInfinity) == 1);
  const Eigen::MatrixXd truth = Eigen::MatrixXd::Identity(2, 2);
  CHECK(std::isnan(wishart_test(kNaN * truth, truth, 100).p_value));
  CHECK(std::isnan(wishart_test(truth, kNaN * truth, 100).p_value));
  // Two vectors of two dimensions lie on a line, six of six in a plane: that is no difference.
  for (const int d : {2, 6}) {
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(d, d);
    const Moments few = Moments::of(draws(d, d, 3).transpose());
    CHECK(std::isnan(wishart_test(few.covariance(), unit, few.count).p_value));
    const Moments enough = Moments::of(draws(d, 4 * d, 3).transpose());
    CHECK(wishart_test(enough.covariance(), unit, enough.count).p_value > 1e-3);
  }
}

TEST_CASE("NEES band is centred on the dimension and shrinks") {
  const Interval b = nees_band(6, 100, 0.95);
  CHECK(b.lo < 6);
  CHECK(b.hi > 6);
  CHECK((b.hi - b.lo) / 2 == Approx(1.96 * std::sqrt(2 * 6.0 / 100)).epsilon(0.01));
}

TEST_CASE("The interval of a mean share stays in [0, 1]") {
  // Events, that is shares of 0 and 1, have the exact interval of their probability
  const Interval exact = binomial_interval(7, 100, 0.95), same = share_interval(0.07, 0.07 * 0.93, 100, 0.95);
  CHECK(same.lo == Approx(exact.lo).epsilon(1e-9));
  CHECK(same.hi == Approx(exact.hi).epsilon(1e-9));
  // One share of 1/9 among 1000: the normal interval would reach below 0
  const double mean = 1.0 / 9000, variance = mean / 9 - mean * mean;
  const Interval rare = share_interval(mean, variance, 1000, 0.95);
  CHECK(rare.lo > 0);
  CHECK(rare.lo < mean);
  CHECK(rare.hi > mean);
  CHECK(mean_interval(mean, variance, 1000, 0.95).lo < 0);
  const Interval never = share_interval(0, 0, 1000, 0.95), always = share_interval(1, 0, 1000, 0.95);
  CHECK(never.lo == 0);
  CHECK(never.hi == Approx(binomial_interval(0, 1000, 0.95).hi).epsilon(1e-9));
  CHECK(always.hi == 1);
  CHECK(always.lo < 1);
}
