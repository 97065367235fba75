#include "stats/simultaneous_band.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <tuple>
#include <vector>

#include <boost/math/quadrature/gauss.hpp>

#include "base/units.h"
#include "stats/intervals.h"
#include "stats/normal_tail.h"

namespace surveymc::stats {
namespace {

/// The smallest x with P(X <= x) >= tail, X binomial(n, u): summed from where nothing is left of it.
std::int64_t lowest_inside(double n, double u, double tail) {
  constexpr double kNothing = 12;  // standard deviations
  const double mean = n * u, sd = std::sqrt(mean * (1 - u));
  double x = std::max(0.0, std::floor(mean - kNothing * sd - kNothing));
  double p = std::exp(std::lgamma(n + 1) - std::lgamma(x + 1) - std::lgamma(n - x + 1) + x * std::log(u) +
                      (n - x) * std::log1p(-u));
  double sum = p;
  while (sum < tail && x < n) {
    p *= (n - x) / (x + 1) * (u / (1 - u));
    sum += p;
    ++x;
  }
  return static_cast<std::int64_t>(x);
}

double exact_coverage(std::uint64_t count, int bins, double gamma) {
  const double n = static_cast<double>(count), rate = n / bins;
  const auto steps = static_cast<std::size_t>(bins);
  std::vector<std::int64_t> lo(steps + 1, 0), hi(steps + 1, static_cast<std::int64_t>(count));
  for (int i = 1; i < bins; ++i) lo[static_cast<std::size_t>(i)] = lowest_inside(n, i / double(bins), gamma / 2);
  for (std::size_t i = 1; i < steps; ++i) hi[i] = static_cast<std::int64_t>(count) - lo[steps - i];
  hi[0] = 0;
  lo[steps] = static_cast<std::int64_t>(count);
  // Increments beyond this have no probability left.
  const auto most = static_cast<std::int64_t>(std::min(n, rate + 12 * std::sqrt(rate) + 30));
  std::vector<double> poisson(static_cast<std::size_t>(most) + 1);
  for (std::int64_t d = 0; d <= most; ++d) {
    const auto k = static_cast<double>(d);
    poisson[static_cast<std::size_t>(d)] = std::exp(k * std::log(rate) - rate - std::lgamma(k + 1));
  }
  std::vector<double> now{1.0}, next;
  for (std::size_t i = 1; i <= steps; ++i) {
    if (hi[i] < lo[i]) return 0;
    next.assign(static_cast<std::size_t>(hi[i] - lo[i]) + 1, 0.0);
    for (std::size_t at = 0; at < now.size(); ++at) {
      const std::int64_t x = lo[i - 1] + static_cast<std::int64_t>(at);
      const std::int64_t first = std::max(lo[i], x), last = std::min(hi[i], x + most);
      const double f = now[at];
      for (std::int64_t y = first; y <= last; ++y)
        next[static_cast<std::size_t>(y - lo[i])] += f * poisson[static_cast<std::size_t>(y - x)];
    }
    now.swap(next);
  }
  return now.front() / std::exp(n * std::log(n) - n - std::lgamma(n + 1));
}

/// P(|B(i / K)| <= z sqrt(u (1 - u)) at all inner points) of a Brownian bridge: a Brownian motion that ends in 0.
double bridge_coverage(int bins, double z) {
  using Rule = boost::math::quadrature::gauss<double, 60>;
  constexpr std::size_t kHalf = 30;
  const auto node = [&](std::size_t i) { return i < kHalf ? -Rule::abscissa()[i] : Rule::abscissa()[i - kHalf]; };
  const auto weight = [&](std::size_t i) { return Rule::weights()[i % kHalf]; };
  const double sd = 1 / std::sqrt(double(bins)), height = 1 / (sd * std::sqrt(2 * kPi));
  const auto step = [&](double from, double to) {
    const double x = (to - from) / sd;
    return height * std::exp(-0.5 * x * x);
  };
  const auto half_width = [&](int i) {
    const double u = i / double(bins);
    return z * std::sqrt(u * (1 - u));
  };
  std::array<double, 2 * kHalf> now, next;
  double width = half_width(1);
  for (std::size_t j = 0; j < now.size(); ++j) now[j] = step(0, width * node(j));
  for (int i = 2; i < bins; ++i) {
    const double wider = half_width(i);
    for (std::size_t k = 0; k < next.size(); ++k) {
      next[k] = 0;
      for (std::size_t j = 0; j < now.size(); ++j)
        next[k] += width * weight(j) * now[j] * step(width * node(j), wider * node(k));
    }
    now = next;
    width = wider;
  }
  double sum = 0;
  for (std::size_t j = 0; j < now.size(); ++j) sum += width * weight(j) * now[j] * step(width * node(j), 0);
  return sum * std::sqrt(2 * kPi);  // over the density of a Brownian motion that is 0 at 1
}

/// How much narrower the band of counts is than that of the bridge, as a normal quantile.
double narrower(std::uint64_t n) { return 0.04 * std::pow(1000 / static_cast<double>(n), 0.25); }

double quantile_of(double level) { return -normal_quantile(level / 2); }

}  // namespace

double pointwise_p(std::uint64_t count, std::uint64_t n, double u) {
  const BinomialTails tails = binomial_tails(count, n, u);
  return std::min(1.0, 2 * std::min(tails.at_most, tails.at_least));
}

double band_coverage(std::uint64_t n, int bins, double gamma) {
  return n <= kMostExact ? exact_coverage(n, bins, gamma) : bridge_coverage(bins, quantile_of(gamma) + narrower(n));
}

double band_level(std::uint64_t n, int bins, double confidence) {
  static std::mutex changing;
  static std::map<std::tuple<std::uint64_t, int, double>, double> known;
  const std::scoped_lock lock(changing);
  double& gamma = known[{n, bins, confidence}];
  if (gamma > 0) return gamma;
  // Between Bonferroni's level, which is always safe, and that of one point alone.
  double lo = std::log((1 - confidence) / (bins - 1)), hi = std::log(1 - confidence);
  while (hi - lo > 1e-3) {
    const double middle = (lo + hi) / 2;
    (band_coverage(n, bins, std::exp(middle)) >= confidence ? lo : hi) = middle;
  }
  return gamma = std::exp(lo);
}

double band_quantile(std::uint64_t n, int bins, double confidence) {
  return quantile_of(band_level(n, bins, confidence));
}

double band_p_value(std::uint64_t n, int bins, double smallest) {
  if (smallest >= 1) return 1;
  const double bonferroni = std::min(1.0, (bins - 1) * smallest);
  constexpr double kDigits = 1e-9;  // what is left of 1 - coverage
  if (bonferroni < kDigits) return bonferroni;
  // Strictly above: counts with just this p are among those that are as extreme.
  return std::clamp(1 - band_coverage(n, bins, smallest * (1 + 1e-9)), smallest, bonferroni);
}

}  // namespace surveymc::stats
