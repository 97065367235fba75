#pragma once
/// Probability of an event from trials that a proposal drew instead of the standard normals: every trial of the event
/// counts with its weight, density of the normals / density of the proposal. Plain trials have the weight 1.
#include <cstdint>
#include <string>

#include "stats/intervals.h"

namespace surveymc::stats {

/// Sums over the hits, the trials at which the event happened.
struct WeightedHits {
  std::uint64_t count = 0;
  double sum = 0;      ///< S1: of the weights
  double squares = 0;  ///< S2, of the weights / 2^scale(): those of weights below 1e-154 are no numbers
  double largest = 0;  ///< m

  /// Exponent of the largest weight. Division by a power of two is exact: it changes no bit of what follows.
  int scale() const;
  /// A weight or a sum of weights / 2^scale().
  double scaled(double weight) const;

  void add(double weight);
  /// `next` holds trials that follow. The order of merging is part of the bits of the sums.
  void merge(const WeightedHits& next);

  /// S1^2 / S2: hits of equal weight that would tell as much (Kish's effective size); 0 without hits.
  double effective_hits() const { return squares > 0 ? scaled(sum) * scaled(sum) / squares : 0; }
  /// m / S1: largest share of one trial in the estimate; 0 without hits.
  double largest_share() const { return sum > 0 ? largest / sum : 0; }
};

/// Interval of p = S1 / trials by gamma distributions (Fay and Feuer 1997). With v = S2 - S1^2/N, u = v + m^2 and
/// G(a; s) the lower a quantile of the gamma distribution of shape s,
///   lo = v/S1 G(tail; S1^2/v) / N,   hi = u/(S1 + m) G(1 - tail; (S1 + m)^2/u) / N.
/// For few hits of equal weight it is the exact interval of a Poisson count. Without hits lo = 0, and hi = -ln(tail)/N
/// where the trials are plain; under a proposal nothing bounds a weight, and hi is NaN.
/// `is_plain`: all weights are 1, hits or not. `trials` > 0.
Interval weighted_interval(const WeightedHits& hits, std::uint64_t trials, double confidence, bool is_plain);

/// A weighted estimate, and whether to trust it.
struct WeightedProbability {
  double value = 0;
  Interval interval;
  double relative_half_width = 0;  ///< of the interval, of the value; NaN without hits
  double relative_efficiency = 0;  ///< p (1 - p) / (N var p): plain trials that one evaluation is worth; NaN: no hits
  bool trusted = false;
  std::string note;  ///< why it is not trusted
};

/// Trusted are estimates of at least kTrustedHits effective hits of which none has more than kTrustedShare.
inline constexpr double kTrustedHits = 100, kTrustedShare = 0.05;

/// `lost`: trials without a result, which count as no hits; their weights may make up kMostLost of those of the hits.
inline constexpr double kMostLost = 0.01;
WeightedProbability weighted_probability(const WeightedHits& hits, const WeightedHits& lost, std::uint64_t trials,
                                         double confidence, bool is_plain);

}  // namespace surveymc::stats
