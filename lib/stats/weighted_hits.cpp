#include "stats/weighted_hits.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <boost/math/distributions/gamma.hpp>

#include "base/units.h"

namespace surveymc::stats {
namespace {

/// Quantile of the gamma distribution of this mean and variance.
double gamma_quantile_of(double mean, double variance, double probability) {
  if (!(variance > 0)) return mean;
  // All but normal: Cornish and Fisher's expansion, where Boost's series have too many terms. What it leaves out is
  // (z^3 - 7 z) / 36 times 1e-15 of the mean at most.
  if (variance < 1e-10 * mean * mean) {
    const double z = normal_quantile(probability);
    return mean + z * std::sqrt(variance) + (z * z - 1) / 3 * variance / mean;
  }
  return boost::math::quantile(boost::math::gamma_distribution<>(mean / variance * mean, variance / mean), probability);
}

/// Square of the weight / 2^e, e its exponent.
double unit_square(double weight) {
  const double unit = std::ldexp(weight, -std::ilogb(weight));
  return unit * unit;
}

}  // namespace

int WeightedHits::scale() const { return largest > 0 && std::isfinite(largest) ? std::ilogb(largest) : 0; }
double WeightedHits::scaled(double weight) const { return std::ldexp(weight, -scale()); }

void WeightedHits::add(double weight) { merge({1, weight, weight > 0 ? unit_square(weight) : 0, weight}); }

void WeightedHits::merge(const WeightedHits& next) {
  const int own = scale(), theirs = next.scale();
  largest = std::max(largest, next.largest);
  count += next.count;
  sum += next.sum;
  // Squares of a scale that lies far below the other are 0, as they are to the last digit of the sum.
  squares = std::ldexp(squares, 2 * (own - scale())) + std::ldexp(next.squares, 2 * (theirs - scale()));
}

Interval weighted_interval(const WeightedHits& hits, std::uint64_t trials, double confidence, bool is_plain) {
  const double tail = (1 - confidence) / 2, n = static_cast<double>(trials);
  if (!(hits.largest > 0)) return {0, is_plain ? std::min(1.0, -std::log(tail) / n) : kNaN};
  // In units of the largest weight: squares of the smallest probabilities are no numbers.
  const double m = hits.scaled(hits.largest);
  const double s1 = hits.sum / hits.largest, s2 = hits.squares / m / m;
  const double v = std::max(0.0, s2 - s1 * s1 / n), u = v + 1;
  const double lo = gamma_quantile_of(s1, v, tail), hi = gamma_quantile_of(s1 + 1, u, 1 - tail);
  return {hits.largest * lo / n, hits.largest * hi / n};
}

WeightedProbability weighted_probability(const WeightedHits& hits, const WeightedHits& lost, std::uint64_t trials,
                                         double confidence, bool is_plain) {
  WeightedProbability p;
  if (trials == 0) return {kNaN, {kNaN, kNaN}, kNaN, kNaN, false, "no trials"};
  const double n = static_cast<double>(trials);
  p.value = hits.sum / n;
  p.interval = is_plain ? binomial_interval(hits.count, trials, confidence)
                        : weighted_interval(hits, trials, confidence, is_plain);
  p.relative_half_width = hits.sum > 0 ? (p.interval.hi - p.interval.lo) / 2 / p.value : kNaN;
  const double scaled = hits.scaled(hits.sum) / n, variance = (hits.squares / n - scaled * scaled) / n;
  p.relative_efficiency = variance > 0 ? std::ldexp(scaled * (1 - p.value) / (n * variance), -hits.scale()) : kNaN;
  const auto tell = [&](const std::string& text) { p.note += (p.note.empty() ? "" : "; ") + text; };
  if (hits.count == 0)
    tell("never hit");
  else if (!(hits.largest > 0))
    tell("every weight is below the smallest number");
  else if (hits.effective_hits() < kTrustedHits)
    tell(fmt::format("{:.3g} effective hits, not {:g}", hits.effective_hits(), kTrustedHits));
  if (hits.largest_share() > kTrustedShare) tell(fmt::format("one hit has {:.2g} of the sum", hits.largest_share()));
  if (lost.sum > kMostLost * hits.sum)
    tell(fmt::format("{} trials without a result weigh {:.2g} of the hits", lost.count,
                     hits.sum > 0 ? lost.sum / hits.sum : kInfinity));
  p.trusted = p.note.empty();
  return p;
}

}  // namespace surveymc::stats
