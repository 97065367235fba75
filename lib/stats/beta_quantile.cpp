#include "stats/beta_quantile.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include <boost/math/special_functions/beta.hpp>
#include <boost/math/tools/roots.hpp>

namespace surveymc::stats {
namespace {

namespace bm = boost::math;

enum class BetaTail { below, above };

double tail_probability(double a, double b, double share, BetaTail tail) {
  return tail == BetaTail::below ? bm::ibeta(a, b, share) : bm::ibetac(a, b, share);
}

/// The share up to about 1/2 whose tail is `probability`, between two numbers that stand close to each other if `start`
/// is right.
double root_near(double start, double a, double b, double probability, BetaTail tail) {
  constexpr double kLeast = std::numeric_limits<double>::min(), kEpsilon = std::numeric_limits<double>::epsilon();
  const double sign = tail == BetaTail::below ? 1 : -1;
  const auto excess = [&](double share) {
    return sign * (tail_probability(a, b, share, tail) / probability - 1);  // rises with the share
  };
  double low = start > kLeast && start < 1 ? start : 0.5, high = low;
  double at_low = excess(low), at_high = at_low;
  double step = 8 * kEpsilon;
  for (; at_low > 0 && low > kLeast; step *= 16) {
    high = low, at_high = at_low;
    low = std::max(kLeast, low / (1 + step));
    at_low = excess(low);
  }
  if (at_low > 0) return 0;
  for (; at_high < 0 && high < 1; step *= 16) {
    low = high, at_low = at_high;
    high = std::min(1.0, high * (1 + step));
    at_high = excess(high);
  }
  if (at_low == 0) return low;
  if (at_high <= 0) return high;
  std::uintmax_t iterations = 200;
  const auto between =
      bm::tools::toms748_solve(excess, low, high, at_low, at_high, bm::tools::eps_tolerance<double>(52), iterations);
  return std::midpoint(between.first, between.second);
}

BetaPoint quantile_at(double a, double b, double probability, BetaTail tail) {
  if (!(probability > 0)) return tail == BetaTail::below ? BetaPoint{0, 1} : BetaPoint{1, 0};
  if (!(probability < 1)) return tail == BetaTail::below ? BetaPoint{1, 0} : BetaPoint{0, 1};
  BetaPoint start{a / (a + b), b / (a + b)};
  try {
    double rest = 0;
    const double share =
        tail == BetaTail::below ? bm::ibeta_inv(a, b, probability, &rest) : bm::ibetac_inv(a, b, probability, &rest);
    start = {share, rest};
  } catch (const bm::evaluation_error&) {  // from the mean
  }
  const bool is_small = (tail_probability(a, b, 0.5, tail) >= probability) == (tail == BetaTail::below);
  if (is_small) {
    const double share = root_near(start.share, a, b, probability, tail);
    return {share, 1 - share};
  }
  const BetaTail other = tail == BetaTail::below ? BetaTail::above : BetaTail::below;
  const double rest = root_near(start.rest, b, a, probability, other);
  return {1 - rest, rest};
}

}  // namespace

BetaPoint beta_quantile(double a, double b, double probability) {
  return quantile_at(a, b, probability, BetaTail::below);
}

BetaPoint beta_upper_quantile(double a, double b, double probability) {
  return quantile_at(a, b, probability, BetaTail::above);
}

double fisher_upper_quantile(double above, double below, double probability) {
  const BetaPoint p = beta_quantile(below / 2, above / 2, probability);
  return below * p.rest / (above * p.share);
}

double student_upper_quantile(double degrees, double probability) {
  return std::sqrt(fisher_upper_quantile(1, degrees, 2 * probability));
}

}  // namespace surveymc::stats
