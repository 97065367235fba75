#include "random/mixing_law.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <boost/math/distributions/inverse_gaussian.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/math/tools/roots.hpp>

namespace surveymc::random {
namespace {

using InverseGaussian = boost::math::inverse_gaussian_distribution<double>;

/// Steps of the table a unit of z, and of the quadrature.
constexpr int kTableSteps = 128, kNodeSteps = 16;
constexpr int kTableSize = static_cast<int>(2 * kLargestNormal) * kTableSteps + 1;

double normal_upper(double z) { return std::erfc(z / std::sqrt(2.0)) / 2; }

bool has_two_values(const LawOf& law) { return law.kind == LawKind::two_point; }

double smaller_value(const LawOf& law) { return 1 / (1 - law.share + law.share * law.ratio * law.ratio); }

double variance_of_mixing(const LawOf& law) {
  switch (law.kind) {
    case LawKind::normal:
      return 0;
    case LawKind::laplace:
      return 1;
    case LawKind::student:
      return law.degrees > 4 ? 2 / (law.degrees - 4) : kInfinity;
    case LawKind::nig:
    case LawKind::asymmetric_nig:
      return 1 / law.shape;
    case LawKind::two_point: {
      const double c = smaller_value(law), square = law.ratio * law.ratio;
      return c * c * (1 - law.share + law.share * square * square) - 1;
    }
  }
  return kNaN;
}

}  // namespace

MixingLaw::MixingLaw(const LawOf& law) : law_(law) {
  if (is_normal()) {
    nodes_ = {{}};
    return;
  }
  if (has_two_values(law)) {
    const double c = smaller_value(law);
    nodes_ = {{c, 1 - law.share}, {c * law.ratio * law.ratio, law.share}};
    return;
  }
  if (law.kind == LawKind::asymmetric_nig) scale_ = 1 / std::sqrt(1 + law.skew * law.skew / law.shape);
  for (int i = 0; i < kTableSize; ++i) {
    const double z = static_cast<double>(i) / kTableSteps - kLargestNormal, v = quantile(z);
    root_.push_back(std::sqrt(v));
    if (i % (kTableSteps / kNodeSteps) == 0)
      nodes_.push_back({v, std::exp(-0.5 * z * z) / (std::sqrt(2 * kPi) * kNodeSteps)});
  }
}

double MixingLaw::quantile(double z) const {
  assert(std::abs(z) <= kLargestNormal);
  const double lower = normal_upper(-z), upper = normal_upper(z);
  switch (law_.kind) {
    case LawKind::normal:
      return 1;
    case LawKind::laplace:
      return z < 0 ? -std::log1p(-lower) : -std::log(upper);
    case LawKind::student: {
      const double a = law_.degrees / 2;
      return (a - 1) / (z < 0 ? boost::math::gamma_q_inv(a, lower) : boost::math::gamma_p_inv(a, upper));
    }
    case LawKind::nig:
    case LawKind::asymmetric_nig: {
      const InverseGaussian v(1, law_.shape);
      return z < 0 ? boost::math::quantile(v, lower) : boost::math::quantile(boost::math::complement(v, upper));
    }
    case LawKind::two_point: {
      // The wider one in the upper tail, if r > 1: V rises with z.
      const double c = smaller_value(law_), other = c * law_.ratio * law_.ratio;
      return other > c ? (upper < law_.share ? other : c) : (lower < law_.share ? other : c);
    }
  }
  return kNaN;
}

MixingLaw::Draw MixingLaw::draw(double z) const {
  if (is_normal()) return {};
  double root;
  if (root_.empty()) {
    root = std::sqrt(quantile(std::clamp(z, -kLargestNormal, kLargestNormal)));
  } else {
    // Lagrange's cubic through the four neighbours. Proposals may draw what no stream does: its last value serves.
    const double at = (std::clamp(z, -kLargestNormal, kLargestNormal) + kLargestNormal) * kTableSteps;
    const int i = std::clamp(static_cast<int>(at), 1, kTableSize - 3);
    const double t = at - i, *y = root_.data() + i;
    root = -t * (t - 1) * (t - 2) / 6 * y[-1] + (t + 1) * (t - 1) * (t - 2) / 2 * y[0] -
           (t + 1) * t * (t - 2) / 2 * y[1] + (t + 1) * t * (t - 1) / 6 * y[2];
  }
  return {scale_ * root, scale_ * law_.skew * (root * root - 1)};
}

double MixingLaw::excess_kurtosis() const {
  if (law_.kind != LawKind::asymmetric_nig) return 3 * variance_of_mixing(law_);
  const double l = law_.shape, b2 = law_.skew * law_.skew / l;
  return (3 + 18 * b2 + 15 * b2 * b2) / l / ((1 + b2) * (1 + b2));
}

double MixingLaw::skewness() const {
  if (law_.kind == LawKind::student && law_.degrees <= 3) return kNaN;
  if (law_.kind != LawKind::asymmetric_nig) return 0;
  return 3 * law_.skew / law_.shape * scale_;
}

std::complex<double> MixingLaw::characteristic(double t) const {
  const double u = scale_ * t, half = 0.5 * u * u;
  switch (law_.kind) {
    case LawKind::normal:
      return std::exp(-half);
    case LawKind::laplace:
      return 1 / (1 + half);
    case LawKind::student: {
      const double a = law_.degrees / 2, x = (a - 1) * half;
      if (x == 0) return 1;
      return std::exp(std::log(2 * boost::math::cyl_bessel_k(a, 2 * std::sqrt(x))) + a / 2 * std::log(x) -
                      boost::math::lgamma(a));
    }
    case LawKind::nig:
      return std::exp(law_.shape * (1 - std::sqrt(1 + 2 * half / law_.shape)));
    case LawKind::asymmetric_nig: {
      const std::complex<double> i(0, 1), s = half - i * (u * law_.skew);
      return std::exp(-i * (u * law_.skew) + law_.shape * (1.0 - std::sqrt(1.0 + 2.0 * s / law_.shape)));
    }
    case LawKind::two_point: {
      double sum = 0;
      for (const MixingNode& n : nodes_) sum += n.weight * std::exp(-half * n.variance);
      return sum;
    }
  }
  return kNaN;
}

double MixingLaw::upper_tail(double x) const {
  double sum = 0;
  for (const MixingNode& n : nodes_)
    sum += n.weight * normal_upper((x / scale_ - law_.skew * (n.variance - 1)) / std::sqrt(n.variance));
  return sum;
}

double MixingLaw::half_width(double probability) const {
  const double tail = (1 - probability) / 2;
  const auto where = [&](const auto& upper) {
    double hi = 1;
    while (upper(hi) > tail) hi *= 2;
    double lo = -1;
    while (upper(lo) < tail) lo *= 2;
    std::uintmax_t steps = 200;
    const auto [a, b] = boost::math::tools::toms748_solve([&](double x) { return std::log(upper(x) / tail); }, lo, hi,
                                                          boost::math::tools::eps_tolerance<double>(48), steps);
    return (a + b) / 2;
  };
  const double above = where([&](double x) { return upper_tail(x); });
  return is_symmetric() ? above : (above + where([&](double x) { return 1 - upper_tail(-x); })) / 2;
}

double sd_of_size(const MixingLaw& law, SizeMeaning size) {
  if (size == SizeMeaning::sd || law.is_normal()) return 1;
  const int sds = size == SizeMeaning::ci68 ? 1 : 2;
  return sds / law.half_width(1 - 2 * normal_upper(sds));
}

}  // namespace surveymc::random
