#include "stats/heavy_tail.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <boost/math/tools/roots.hpp>

#include "stats/normal_tail.h"

namespace surveymc::stats {
namespace {

/// The sum over t of several parts is as good.
constexpr double kLeast = 1e-8;

double normal_share(const std::vector<HeavyPart>& parts) {
  double rest = 1;
  for (const HeavyPart& p : parts) rest -= p.weight * p.weight;
  return std::max(0.0, rest);
}

double beyond_of_one(const HeavyPart& part, double rest, double k) {
  const random::MixingLaw& law = *part.law;
  double sum = 0;
  for (const random::MixingNode& n : law.nodes()) {
    const double scaled = part.weight * law.scale(), shift = scaled * law.skew() * (n.variance - 1),
                 sd = std::sqrt(scaled * scaled * n.variance + rest);
    sum += n.weight * (normal_upper_tail(k - shift, sd) + normal_upper_tail(k + shift, sd));
  }
  return sum;
}

/// The sum over t has the period 2 pi / step: what lies beyond a quarter of it has a probability of less than 1e-9.
double period_of(const std::vector<HeavyPart>& parts) {
  double period = 32;
  for (const HeavyPart& p : parts) {
    const auto outside = [&](double x) { return p.law->upper_tail(x) + 1 - p.law->upper_tail(-x); };
    while (period < 2e4 && outside(period / (4 * std::abs(p.weight))) > 1e-9) period *= 2;
  }
  return period;
}

}  // namespace

std::vector<HeavyPart> heavy_parts(const std::vector<random::MixingSlot>& slots,
                                   const std::vector<std::int32_t>& slot_of,
                                   const Eigen::Ref<const Eigen::VectorXd>& along, double variance) {
  std::vector<double> square(slots.size()), sum(slots.size());
  for (std::size_t d = 0; d < slot_of.size(); ++d)
    if (slot_of[d] >= 0) {
      const auto slot = static_cast<std::size_t>(slot_of[d]);
      const double x = along[static_cast<Eigen::Index>(d)];
      square[slot] += x * x;
      sum[slot] += x;
    }
  std::vector<HeavyPart> out;
  for (std::size_t s = 0; s < slots.size(); ++s)
    if (square[s] > 0) out.push_back({slots[s].law, std::copysign(std::sqrt(square[s] / variance), sum[s])});
  return out;
}

std::vector<double> beyond(const std::vector<HeavyPart>& all, const std::vector<double>& k) {
  std::vector<HeavyPart> parts;
  for (const HeavyPart& p : all)
    if (p.weight != 0 && !p.law->is_normal()) parts.push_back(p);
  const double rest = normal_share(parts);
  std::vector<double> out;
  if (parts.size() < 2) {
    for (const double x : k) out.push_back(parts.empty() ? 2 * normal_upper_tail(x) : beyond_of_one(parts[0], rest, x));
    return out;
  }
  // P(x < a) = 1/2 - sum_j Im(phi(t_j) exp(-i a t_j)) / (pi (j + 1/2)),  t_j = (j + 1/2) step.
  const double step = 2 * kPi / period_of(parts);
  out.assign(k.size(), 1);
  constexpr int kMost = 1 << 20;
  for (int j = 0; j < kMost; ++j) {
    const double t = (j + 0.5) * step;
    std::complex<double> phi = std::exp(-0.5 * rest * t * t);
    for (const HeavyPart& p : parts) phi *= p.law->characteristic(p.weight * t);
    // In both tails together the imaginary part of phi cancels.
    for (std::size_t i = 0; i < k.size(); ++i) out[i] -= 2 * phi.real() * std::sin(k[i] * t) / (kPi * (j + 0.5));
    if (std::abs(phi) < 1e-12 * (j + 0.5)) break;
  }
  for (double& p : out) p = p < kLeast ? kNaN : std::min(p, 1.0);
  return out;
}

double quantile_beyond(const std::vector<HeavyPart>& parts, double probability) {
  // A probability that is too small to be known is smaller than the one that is sought, if that one can be known.
  if (parts.size() > 1 && probability < kLeast) return kNaN;
  const auto excess = [&](double k) {
    const double p = beyond(parts, {k})[0];
    return std::log((std::isnan(p) ? kLeast / 2 : std::max(1e-300, p)) / probability);
  };
  double hi = 1;
  while (excess(hi) > 0) hi *= 2;
  std::uintmax_t steps = 100;
  const auto [a, b] = boost::math::tools::toms748_solve(excess, hi == 1 ? 1e-6 : hi / 2, hi,
                                                        boost::math::tools::eps_tolerance<double>(30), steps);
  return (a + b) / 2;
}

}  // namespace surveymc::stats
