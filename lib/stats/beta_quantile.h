#pragma once
/// Quantiles of the beta distribution and its relatives at any tail, to 2e-14, or half an epsilon times the larger of a
/// and b where that is more. Boost's inverse of the incomplete beta function gives up at some tails (in double at some
/// of those below 2e-9, in long double below 1e-10), and beside 1 it may have no digit right. Its distribution function
/// is right: the quantile is its root, sought from Boost's value where there is one.

namespace surveymc::stats {

/// A share and its complement to 1; neither loses digits where the other is close to 1.
struct BetaPoint {
  double share, rest;
};

/// Lower or upper quantile of Beta(a, b) at this probability; a, b > 0. 0 and 1 at the ends.
BetaPoint beta_quantile(double a, double b, double probability);
BetaPoint beta_upper_quantile(double a, double b, double probability);

/// Upper quantile of Fisher's F with `above` and `below` degrees of freedom: (below / above) rest / share of the
/// quantile of Beta(below/2, above/2); and of Student's t, whose square is F(1, degrees), for probabilities up to 1/2.
double fisher_upper_quantile(double above, double below, double probability);
double student_upper_quantile(double degrees, double probability);

}  // namespace surveymc::stats
