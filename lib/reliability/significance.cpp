#include "reliability/significance.h"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <boost/math/distributions/non_central_t.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/tools/roots.hpp>

#include "base/units.h"
#include "stats/beta_quantile.h"

namespace surveymc::reliability {
namespace {

namespace bm = boost::math;

/// What Boost makes of its default inside: with the default itself, it would compile all twice.
using Policy = bm::policies::policy<bm::policies::promote_float<false>>;
using Normal = bm::normal_distribution<double, Policy>;
using ChiSquared = bm::chi_squared_distribution<double, Policy>;
using NonCentralChiSquared = bm::non_central_chi_squared_distribution<double, Policy>;
using NonCentralT = bm::non_central_t_distribution<double, Policy>;
using FisherF = bm::fisher_f_distribution<double, Policy>;

double upper_quantile(double p) { return bm::quantile(bm::complement(Normal(), p)); }
double phi(double x) { return bm::cdf(Normal(), x); }

}  // namespace

double two_sided_alpha(const TestLevels& levels) {
  return levels.tails == Tails::one ? 2 * levels.alpha : levels.alpha;
}

double w_critical(const TestLevels& levels) { return upper_quantile(two_sided_alpha(levels) / 2); }

double lambda0(const TestLevels& levels) { return w_critical(levels) - upper_quantile(levels.power); }

double w_power(double lambda, double critical) { return phi(lambda - critical) + phi(-lambda - critical); }

double chi_squared_power(double r, double noncentrality, double critical) {
  if (!(noncentrality > 0)) return bm::cdf(bm::complement(ChiSquared(r), critical));
  return bm::cdf(bm::complement(NonCentralChiSquared(r, noncentrality), critical));
}

double pope_power(double lambda, double redundancy, double alpha) {
  if (!(redundancy > 1)) return 0;
  const double t = stats::student_upper_quantile(redundancy - 1, alpha / 2);
  if (lambda == 0) return alpha;
  const NonCentralT law(redundancy - 1, std::abs(lambda));
  return bm::cdf(bm::complement(law, t)) + bm::cdf(law, -t);
}

double chi_squared_critical(double r, double alpha) { return bm::quantile(bm::complement(ChiSquared(r), alpha)); }

double fisher_critical(double r, double redundancy, double alpha) {
  const double rest = redundancy - r;
  return rest > 0 ? stats::fisher_upper_quantile(r, rest, alpha) : kInfinity;
}

double tau_squared_critical(double r, double redundancy, double alpha) {
  const double f = fisher_critical(r, redundancy, alpha);
  return std::isfinite(f) ? redundancy * f / (redundancy - r + r * f) : kInfinity;
}

double pope_critical(double redundancy, double alpha) {
  if (!(redundancy > 1)) return kInfinity;
  const double t = stats::student_upper_quantile(redundancy - 1, alpha / 2);
  return std::sqrt(redundancy) * t / std::sqrt(redundancy - 1 + t * t);
}

double chi_squared_p_value(double r, double statistic) {
  if (std::isnan(statistic)) return statistic;
  return std::isfinite(statistic) ? bm::cdf(bm::complement(ChiSquared(r), std::max(0.0, statistic))) : 0;
}

double w_p_value(double w) { return std::isnan(w) ? w : 2 * bm::cdf(bm::complement(Normal(), std::abs(w))); }

DimensionLevel b_method_level(double r, double lambda0_squared, double power) {
  const double critical = bm::quantile(bm::complement(NonCentralChiSquared(r, lambda0_squared), power));
  return {bm::cdf(bm::complement(ChiSquared(r), critical)), critical};
}

double identification_probability(double lambda, double rho) {
  const double a = lambda * std::sqrt((1 - rho) / 2), b = lambda * std::sqrt((1 + rho) / 2);
  return phi(a) * phi(b) + phi(-a) * phi(-b);
}

double identifiable_shift(double rho, double power) {
  const double size = std::abs(rho);
  if (!(1 - size > 1e-12)) return kInfinity;
  if (power <= 0.5) return 0;
  // Between the shift that the weaker factor needs alone, and one at which each factor fails with half of the permitted
  // probability.
  double lo = 0, hi = upper_quantile((1 - power) / 2) / std::sqrt((1 - size) / 2);
  const auto excess = [&](double lambda) { return identification_probability(lambda, size) - power; };
  std::uintmax_t iterations = 200;
  const auto bracket = bm::tools::toms748_solve(excess, lo, hi, bm::tools::eps_tolerance<double>(48), iterations);
  return (bracket.first + bracket.second) / 2;
}

}  // namespace surveymc::reliability
