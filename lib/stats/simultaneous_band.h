#pragma once
/// A band in which the empirical distribution function of uniform values lies at all inner points of a grid at once
/// (Säilynoja, Bürkner and Vehtari 2022, Graphical test for discrete uniformity, section 2).
///
/// Of n values of a uniform variable, X_i = #(u < i / K) is binomial(n, i / K), i = 1 .. K - 1. With the pointwise
///   p_i = 2 min(P(X_i <= x_i), P(X_i >= x_i))
/// the band holds the counts whose every p_i is at least gamma. The probability of that is exact: increments of
/// counts are Poisson(n / K), given that they sum to n, so that
///   f_{i+1}(y) = sum_x f_i(x) Poisson(y - x; n / K), each kept within its limits, and f_K(n) / Poisson(n; n).
/// Above kMostExact values the counts are taken as a Brownian bridge, whose quantile is 0.04 (1000 / n)^(1/4) too wide.
#include <cstdint>

namespace surveymc::stats {

inline constexpr std::uint64_t kMostExact = 20'000;

/// Pointwise p of `count` values below u out of n; u in (0, 1).
double pointwise_p(std::uint64_t count, std::uint64_t n, double u);

/// P(every p_i >= gamma) of n uniform values, K = `bins`.
double band_coverage(std::uint64_t n, int bins, double gamma);

/// The largest gamma whose band holds all points with probability `confidence`, to a part in a thousand. Kept for every
/// (n, bins, confidence) that was asked for; may be called from several threads.
double band_level(std::uint64_t n, int bins, double confidence);

/// The same as a normal quantile: the band is i / K +- z sqrt(u (1 - u) / n).
double band_quantile(std::uint64_t n, int bins, double confidence);

/// P(the smallest p_i of n uniform values <= smallest): p-value of a whole distribution function.
double band_p_value(std::uint64_t n, int bins, double smallest);

}  // namespace surveymc::stats
