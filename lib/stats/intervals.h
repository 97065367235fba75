#pragma once
/// Confidence intervals. All take the confidence level in (0, 1), two-sided with equal tails.
#include <cstdint>

namespace surveymc::stats {

struct Interval {
  double lo = 0, hi = 0;
};

/// Standard normal quantile and the chi-squared quantile (lower tail).
double normal_quantile(double probability);
double chi_squared_quantile(double degrees, double probability);
/// P(chi2 > x); NaN of NaN: what could not be computed speaks against nothing.
double chi_squared_upper_tail(double degrees, double x);
/// P(T > t) of Student's t; NaN of NaN.
double student_upper_tail(double degrees, double t);

/// Standard deviation from a sample variance of `count` values: chi-squared with effective degrees of freedom
/// 2 (n - 1) / (kurtosis - 1), which is n - 1 for normal values. Heavier tails (kurtosis > 3) make it wider; lighter
/// ones are taken as normal, on the safe side.
Interval sd_interval(double variance, std::uint64_t count, double kurtosis, double confidence);

/// Mean from its sample variance: by Student's t of fewer than 100 values, beyond in normal approximation.
Interval mean_interval(double mean, double variance, std::uint64_t count, double confidence);
/// The same of at least two values that may be few: by Student's t, exact for normal values.
Interval student_mean_interval(double mean, double variance, std::uint64_t count, double confidence);

/// Mean of at least two squares (a mean squared error) from their sample variance: chi-squared with effective degrees
/// of freedom 2 count mean^2 / variance, which is `count` for squares of normal values, at the tails that Student's t
/// has in the place of the normal distribution, since the variance comes from as few. Both ends are above 0, and each
/// is missed as often as the other, where mean -+ half width would lie too low.
Interval mean_square_interval(double mean, double variance, std::uint64_t count, double confidence);

/// Probability of an event seen `successes` times in `trials`: exact (Clopper and Pearson 1934).
Interval binomial_interval(std::uint64_t successes, std::uint64_t trials, double confidence);

/// Mean of shares in [0, 1] from their sample variance, inside [0, 1]: Clopper and Pearson's interval for the number of
/// independent events that would have this variance (Korn and Graubard 1998), at least `count` of them.
Interval share_interval(double mean, double variance, std::uint64_t count, double confidence);

/// P(A) - P(B) of two events in the same trials, seen so often alone, A without B and B without A: ends of the exact
/// intervals of both shares, each at (1 + confidence) / 2, so that the difference holds at least its confidence
/// (Bonferroni).
Interval paired_difference_interval(std::uint64_t a_alone, std::uint64_t b_alone, std::uint64_t trials,
                                    double confidence);

/// P(X <= events) and P(X >= events) of a binomial X.
struct BinomialTails {
  double at_most = 1, at_least = 1;
};
BinomialTails binomial_tails(std::uint64_t events, std::uint64_t trials, double probability);

/// Band in which the mean of `count` chi-squared(dimension) values (NEES, NIS) lies.
Interval nees_band(double dimension, std::uint64_t count, double confidence);

}  // namespace surveymc::stats
