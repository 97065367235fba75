#include "orders/mixture.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "stats/linear_algebra.h"
#include "stats/normal_tail.h"

namespace surveymc::orders {
namespace {

struct Line {
  double weight, mean, sd;
};
std::vector<Line> along(const Mixture& mixture, const Eigen::Vector3d& direction) {
  std::vector<Line> parts;
  for (const MixturePart& p : mixture)
    parts.push_back(
        {p.weight, direction.dot(p.mean), std::sqrt(std::max(0.0, direction.dot(p.covariance * direction)))});
  return parts;
}

/// P(N <= x); a normal without spread is a step.
double below(double x, double mean, double sd) {
  return sd > 0 ? stats::normal_upper_tail(mean - x, sd) : x >= mean ? 1 : 0;
}

double below(const std::vector<Line>& parts, double x) {
  double p = 0;
  for (const Line& l : parts) p += l.weight * below(x, l.mean, l.sd);
  return p;
}

/// P(x^2 + y^2 <= k^2), x ~ N(mean[0], narrow^2), y ~ N(mean[1], wide^2), independent.
double inside_circle(double k, const Eigen::Vector2d& mean, double narrow, double wide) {
  const auto of_chord = [&](double half) { return below(half, mean[1], wide) - below(-half, mean[1], wide); };
  if (!(narrow > 1e-9 * k)) return std::abs(mean[0]) < k ? of_chord(std::sqrt(k * k - mean[0] * mean[0])) : 0;
  // x = k sin a: the integrand is smooth and even about its ends, so that the midpoint rule is right to 1e-6.
  constexpr int kNodes = 48;
  constexpr double kReach = 8;
  const double from = std::asin(std::clamp((mean[0] - kReach * narrow) / k, -1.0, 1.0)),
               step = (std::asin(std::clamp((mean[0] + kReach * narrow) / k, -1.0, 1.0)) - from) / kNodes;
  double sum = 0;
  for (int i = 0; i < kNodes; ++i) {
    const double a = from + (i + 0.5) * step, u = (k * std::sin(a) - mean[0]) / narrow;
    sum += std::exp(-0.5 * u * u) * of_chord(k * std::cos(a)) * std::cos(a);
  }
  return sum * step * k / (narrow * std::sqrt(2 * kPi));
}

}  // namespace

Moments moments_of(const Mixture& mixture) {
  Moments m;
  for (const MixturePart& p : mixture) m.mean += p.weight * p.mean;
  for (const MixturePart& p : mixture) {
    const Eigen::Vector3d off = p.mean - m.mean;
    m.covariance += p.weight * (p.covariance + off * off.transpose());
  }
  return m;
}

Shape shape_along(const Mixture& mixture, const Eigen::Vector3d& direction) {
  const std::vector<Line> parts = along(mixture, direction);
  Shape s;
  for (const Line& l : parts) s.mean += l.weight * l.mean;
  double second = 0, third = 0, fourth = 0;
  for (const Line& l : parts) {
    const double d = l.mean - s.mean, d2 = d * d, v = l.sd * l.sd;
    second += l.weight * (d2 + v);
    third += l.weight * d * (d2 + 3 * v);
    fourth += l.weight * (d2 * d2 + 6 * d2 * v + 3 * v * v);
  }
  s.sd = std::sqrt(second);
  s.skewness = second > 0 ? third / (second * s.sd) : kNaN;
  s.kurtosis = second > 0 ? fourth / (second * second) : kNaN;
  return s;
}

double quantile(const Mixture& mixture, const Eigen::Vector3d& direction, double p) {
  const std::vector<Line> parts = along(mixture, direction);
  double lo = kInfinity, hi = -kInfinity;
  for (const Line& l : parts) {
    lo = std::min(lo, l.mean - 12 * l.sd);
    hi = std::max(hi, l.mean + 12 * l.sd);
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (lo + hi);
    (below(parts, middle) < p ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

double density(const Mixture& mixture, const Eigen::Vector3d& direction, double x) {
  double sum = 0;
  for (const Line& l : along(mixture, direction)) {
    if (!(l.sd > 0)) continue;
    const double u = (x - l.mean) / l.sd;
    sum += l.weight * std::exp(-0.5 * u * u) / (l.sd * std::sqrt(2 * kPi));
  }
  return sum;
}

std::vector<double> inside_ellipse(const Mixture& mixture, const Eigen::Vector3d& centre, const Eigen::Matrix3d& c,
                                   const std::vector<double>& k) {
  const Eigen::Matrix2d horizontal = c.topLeftCorner<2, 2>();
  const auto body = stats::symmetric_eigen(horizontal);
  if (!(body.values[0] > 1e-14 * body.values[1])) return std::vector<double>(k.size(), kNaN);
  const Eigen::Matrix2d whiten = body.values.cwiseSqrt().cwiseInverse().asDiagonal() * body.vectors.transpose();
  std::vector<double> inside(k.size(), 0.0);
  for (const MixturePart& part : mixture) {
    constexpr double kNegligible = 1e-9;
    if (part.weight < kNegligible) continue;
    // Along the narrow axis by quadrature, along the wide one exactly.
    const auto own = stats::symmetric_eigen<2>(whiten * part.covariance.topLeftCorner<2, 2>() * whiten.transpose());
    const Eigen::Vector2d mean = own.vectors.transpose() * whiten * (part.mean - centre).head<2>();
    const double narrow = std::sqrt(std::max(0.0, own.values[0])), wide = std::sqrt(std::max(0.0, own.values[1]));
    for (std::size_t j = 0; j < k.size(); ++j) inside[j] += part.weight * inside_circle(k[j], mean, narrow, wide);
  }
  return inside;
}

}  // namespace surveymc::orders
