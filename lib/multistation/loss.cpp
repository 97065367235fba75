#include "multistation/loss.h"

#include <array>
#include <cmath>

#include "base/error.h"
#include "base/units.h"

namespace surveymc::multistation {
namespace {

/// Density of the length of `components` standard normals.
double chi_density(int components, double t) {
  const double normalised = std::exp2(components / 2.0 - 1) * std::tgamma(components / 2.0);
  return std::pow(t, components - 1) * std::exp(-t * t / 2) / normalised;
}

constexpr int kSteps = 20'000;
constexpr double kLongest = 12;  // the density is below 1e-30 beyond it

/// The mean of f(t), by the midpoint rule: the weights have kinks, so that no rule of high order does better.
template <class F>
double mean_of(int components, const F& f) {
  constexpr double step = kLongest / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) * step;
    sum += f(t) * chi_density(components, t);
  }
  return sum * step;
}

}  // namespace

const std::vector<std::string>& loss_names() {
  static const std::vector<std::string> names{"least_squares", "l1", "huber", "cauchy", "tukey"};
  return names;
}

double scale_of_median(int components) {
  require(components >= 1 && components <= 3, "a station has one to three components, not {}", components);
  constexpr std::array<double, 3> kMedian{0.67448975019608171, 1.1774100225154747, 1.5381722544550522};
  return kMedian[static_cast<std::size_t>(components - 1)];
}

LossCost loss_cost(Loss loss, int components) {
  if (loss == Loss::least_squares) return {};
  const auto weight = [&](double t) { return station_weight<double>(loss, t * t); };
  const double d = components;
  LossCost cost;
  cost.mean_trust = mean_of(components, [&](double t) { return station_trust(weight(t)); });
  const double squares = mean_of(components, [&](double t) { return std::pow(weight(t) * t, 2); }) / d;
  // E[w + w' t / d] by parts: E[w t^2] / d, as the density f of t has (t f)' = (d - t^2) f.
  cost.slope = mean_of(components, [&](double t) { return weight(t) * t * t; }) / d;
  cost.variance = squares / (cost.slope * cost.slope);
  return cost;
}

}  // namespace surveymc::multistation
