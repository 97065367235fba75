#include "stats/intervals.h"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

#include "base/units.h"
#include "stats/beta_quantile.h"
#include "stats/normal_tail.h"

namespace surveymc::stats {

namespace bm = boost::math;

namespace {

/// Quantiles of 0 and 1 are infinite instead of an exception: of a confidence that rounds to 1 the interval is.
using Infinite = bm::policies::policy<bm::policies::overflow_error<bm::policies::ignore_error>>;
using ChiSquared = bm::chi_squared_distribution<double, Infinite>;

}  // namespace

double normal_quantile(double probability) {
  return bm::quantile(bm::normal_distribution<double, Infinite>(), probability);
}
double chi_squared_quantile(double degrees, double probability) {
  return bm::quantile(ChiSquared(degrees), probability);
}
double chi_squared_upper_tail(double degrees, double x) {
  if (std::isnan(x)) return x;
  return x < kInfinity ? bm::cdf(bm::complement(bm::chi_squared(degrees), std::max(0.0, x))) : 0.0;
}
double student_upper_tail(double degrees, double t) {
  return std::isnan(t) ? t : bm::cdf(bm::complement(bm::students_t(degrees), t));
}

Interval sd_interval(double variance, std::uint64_t count, double kurtosis, double confidence) {
  const double tail = (1 - confidence) / 2;
  const double normal_degrees = static_cast<double>(count) - 1;
  const double degrees = std::isfinite(kurtosis) && kurtosis > 3 ? 2 * normal_degrees / (kurtosis - 1) : normal_degrees;
  const auto bound = [&](double p) { return std::sqrt(variance * degrees / chi_squared_quantile(degrees, p)); };
  return {bound(1 - tail), bound(tail)};
}

Interval mean_interval(double mean, double variance, std::uint64_t count, double confidence) {
  constexpr std::uint64_t kMany = 100;  // from here on Student's interval is less than 1.3 % wider at 95 %
  if (count > 1 && count < kMany) return student_mean_interval(mean, variance, count, confidence);
  const double half = normal_quantile(1 - (1 - confidence) / 2) * std::sqrt(variance / static_cast<double>(count));
  return {mean - half, mean + half};
}

Interval student_mean_interval(double mean, double variance, std::uint64_t count, double confidence) {
  const double n = static_cast<double>(count);
  const double half = student_upper_quantile(n - 1, (1 - confidence) / 2) * std::sqrt(variance / n);
  return {mean - half, mean + half};
}

Interval mean_square_interval(double mean, double variance, std::uint64_t count, double confidence) {
  if (!(mean > 0) || !(variance > 0)) return {mean, mean};
  const double n = static_cast<double>(count), degrees = 2 * n * mean / variance * mean;
  const double t = student_upper_quantile(n - 1, (1 - confidence) / 2), tail = normal_upper_tail(t);
  constexpr double kAllButNormal = 1e9;  // where Boost's series have too many terms
  if (degrees > kAllButNormal) {
    const double half = t * std::sqrt(variance / n);
    return {mean - half, mean + half};
  }
  if (!(degrees > 0)) return {0, kInfinity};  // the variance is too large for a number
  const ChiSquared chi(degrees);
  return {mean * degrees / bm::quantile(bm::complement(chi, tail)), mean * degrees / bm::quantile(chi, tail)};
}

Interval binomial_interval(std::uint64_t successes, std::uint64_t trials, double confidence) {
  const double tail = (1 - confidence) / 2, n = static_cast<double>(trials), k = static_cast<double>(successes);
  return {successes > 0 ? beta_quantile(k, n - k + 1, tail).share : 0,
          successes < trials ? beta_upper_quantile(k + 1, n - k, tail).share : 1};
}

Interval share_interval(double mean, double variance, std::uint64_t count, double confidence) {
  const double tail = (1 - confidence) / 2, least = static_cast<double>(count);
  // Shares vary no more than events of their probability, so there are `count` of these or more
  double n = least;
  if (variance > 0 && mean > 0 && mean < 1) n = std::max(least, least * mean * (1 - mean) / variance);
  const double k = mean * n;
  return {k > 0 ? beta_quantile(k, n - k + 1, tail).share : 0,
          k < n ? beta_upper_quantile(k + 1, n - k, tail).share : 1};
}

Interval paired_difference_interval(std::uint64_t a_alone, std::uint64_t b_alone, std::uint64_t trials,
                                    double confidence) {
  const Interval a = binomial_interval(a_alone, trials, (1 + confidence) / 2),
                 b = binomial_interval(b_alone, trials, (1 + confidence) / 2);
  return {a.lo - b.hi, a.hi - b.lo};
}

BinomialTails binomial_tails(std::uint64_t events, std::uint64_t trials, double probability) {
  const bm::binomial_distribution<> x(static_cast<double>(trials), std::clamp(probability, 0.0, 1.0));
  const auto k = static_cast<double>(events);
  return {bm::cdf(x, k), events == 0 ? 1 : bm::cdf(bm::complement(x, k - 1))};
}

Interval nees_band(double dimension, std::uint64_t count, double confidence) {
  const double n = static_cast<double>(count), tail = (1 - confidence) / 2;
  return {chi_squared_quantile(n * dimension, tail) / n, chi_squared_quantile(n * dimension, 1 - tail) / n};
}

}  // namespace surveymc::stats
