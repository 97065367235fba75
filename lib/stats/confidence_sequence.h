#pragma once
/// Confidence sequences: intervals that hold at all numbers of trials at once, so that a run may look at them as often
/// as it likes and stop whenever it likes. Two-sided normal mixture (Howard, Ramdas, McAuliffe and Sekhon 2021), with
/// estimated standard errors asymptotic (Waudby-Smith, Arbour, Sinha, Kennedy and Ramdas 2024).
///
///   c(n) = sqrt((n + rho) / n (ln(1 + n / rho) + 2 ln(1 / alpha))),
///   rho = n_opt / (2 ln(1 / alpha) + ln(1 + 2 ln(1 / alpha)))
/// is to a sequence what the normal quantile is to one interval: half width = c(n) standard errors. It is narrowest, by
/// this measure, at n_opt trials. alpha = 1 - confidence.
#include "stats/sample_summary.h"

namespace surveymc::stats {

/// Ten first looks of 4096 trials.
inline constexpr double kSequenceOptimum = 40'960;

/// c(n); n >= 1, confidence in (0, 1).
double sequence_quantile(std::uint64_t n, double confidence);

/// The confidence at which one interval is as wide as the sequence at n: 2 Phi(c(n)) - 1.
double sequence_confidence(std::uint64_t n, double confidence);

/// The smallest 1 - confidence at which a sequence of n units leaves out what lies z standard errors away: p-value that
/// holds at all looks at once, one over the mixture's likelihood ratio, at most 1. n_opt stays that of 95 %.
double sequence_p(std::uint64_t n, double z);

/// Of a standard deviation: ln sd +- c(n) sqrt((kurtosis - 1) / (4 n)), kurtosis of a unit, at least 3.
Interval sd_sequence(const SampleSummary& s, double confidence);

/// Of the probability of an event seen `successes` times in `trials`: all p for which the beta-binomial mixture with
/// prior beta(r / (1 - p), r / p) does not reach 1 / alpha. Exact for counts.
///   r = max(rho p (1 - p) - p (1 - p), p (1 - p) / 1000), rho as above
Interval rate_sequence(std::uint64_t successes, std::uint64_t trials, double confidence);

/// The smallest 1 - confidence at which the sequence of these counts leaves out `probability`: one over the mixture's
/// likelihood ratio, at most 1. n_opt stays that of 95 %.
double rate_sequence_p(std::uint64_t successes, std::uint64_t trials, double probability);

}  // namespace surveymc::stats
