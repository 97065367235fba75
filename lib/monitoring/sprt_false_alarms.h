#pragma once
/// Probability that an SPRT raises an alarm, by integration instead of simulation.
#include <vector>

#include "monitoring/sequential_tests.h"

namespace surveymc::monitoring {

/// P(the test of mean 0 against +shift, one side of class Sprt, has accepted H1 by sample i + 1), i = 0 .. samples - 1,
/// for independent normal samples with this mean and sd. The sum S between its bounds has the density f and, just after
/// an acceptance of H0, an atom at 0:
///   f'(y) = int k(y - x) f(x) dx + atom k(y),  k the density of an increment of S
/// on three Gauss nodes in every half sd of the increment: relative error below 1e-6 (tests). NaN where that takes more
/// than kMostSprtPanels of such panels: the increments are small against the distance of the bounds.
std::vector<double> sprt_alarm_probability(const SprtOptions& options, double mean, double sd, int samples);
inline constexpr int kMostSprtPanels = 400;

/// P(either side of a test has raised an alarm) from the probability of one side: between that of independent and that
/// of exclusive sides. The sides are nearly exclusive, because a sample that raises one sum lowers the other.
struct TwoSided {
  double independent, exclusive;
};
TwoSided two_sided_alarm_probability(double one_side);

}  // namespace surveymc::monitoring
