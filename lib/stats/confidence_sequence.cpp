#include "stats/confidence_sequence.h"

#include <algorithm>
#include <cmath>

#include "stats/normal_tail.h"

namespace surveymc::stats {
namespace {

/// rho for one trial of n_opt = 1.
double sequence_rho(double confidence) {
  const double twice = -2 * std::log(1 - confidence);
  return 1 / (twice + std::log1p(twice));
}

double log_beta(double a, double b) { return std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b); }

/// ln of the likelihood of x of n by the beta-binomial mixture over that by p; p in (0, 1).
double log_rate_ratio(double x, double n, double p, double rho) {
  const double q = 1 - p, variance = p * q, r = variance * std::max(rho - 1, 1e-3), a = r / q, b = r / p;
  return log_beta(a + x, b + n - x) - log_beta(a, b) - x * std::log(p) - (n - x) * std::log1p(-p);
}

}  // namespace

double sequence_quantile(std::uint64_t count, double confidence) {
  const double n = static_cast<double>(count), rho = kSequenceOptimum * sequence_rho(confidence);
  return std::sqrt((n + rho) / n * (std::log1p(n / rho) - 2 * std::log(1 - confidence)));
}

double sequence_confidence(std::uint64_t count, double confidence) {
  return 1 - 2 * normal_upper_tail(sequence_quantile(count, confidence));
}

double sequence_p(std::uint64_t count, double z) {
  const double n = static_cast<double>(count), rho = kSequenceOptimum * sequence_rho(0.95);
  return std::min(1.0, std::exp(-0.5 * (z * z * n / (n + rho) - std::log1p(n / rho))));
}

Interval sd_sequence(const SampleSummary& s, double confidence) {
  const double sd = std::sqrt(s.variance),
               kurtosis = std::max(3.0, std::isfinite(s.unit_kurtosis) ? s.unit_kurtosis : 3);
  const double half =
      sequence_quantile(s.units, confidence) * std::sqrt((kurtosis - 1) / 4 / static_cast<double>(s.units));
  return {sd * std::exp(-half), sd * std::exp(half)};
}

Interval rate_sequence(std::uint64_t successes, std::uint64_t trials, double confidence) {
  const auto x = static_cast<double>(successes), n = static_cast<double>(trials);
  const double rho = kSequenceOptimum * sequence_rho(confidence), enough = -std::log(1 - confidence);
  const auto is_out = [&](double p) { return log_rate_ratio(x, n, p, rho) >= enough; };
  const auto edge = [&](double inside, double outside) {
    if (inside == outside) return inside;
    for (int i = 0; i < 200 && std::abs(inside - outside) > 1e-15; ++i) {
      const double middle = (inside + outside) / 2;
      (is_out(middle) ? outside : inside) = middle;
    }
    return inside;
  };
  const double p = x / n;
  return {edge(p, 0), edge(p, 1)};
}

double rate_sequence_p(std::uint64_t successes, std::uint64_t trials, double probability) {
  if (!(probability > 0)) return successes > 0 ? 0 : 1;
  if (!(probability < 1)) return successes < trials ? 0 : 1;
  const double rho = kSequenceOptimum * sequence_rho(0.95);
  return std::min(
      1.0, std::exp(-log_rate_ratio(static_cast<double>(successes), static_cast<double>(trials), probability, rho)));
}

}  // namespace surveymc::stats
