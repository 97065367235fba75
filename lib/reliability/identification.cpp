#include "reliability/identification.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "base/units.h"
#include "stats/normal_tail.h"

namespace surveymc::reliability {
namespace {

/// Integral of R^2 phi(R - c) over R > from: with x = R - c, (x + c)^2 phi(x) has a closed integral.
double radial(double from, double c) {
  const double x = from - c, density = std::exp(-x * x / 2) / std::sqrt(2 * kPi), above = stats::normal_upper_tail(x);
  return (x + 2 * c) * density + (1 + c * c) * above;
}

/// Quantile v of the cosine of the angle between t = shift + N(0, 1) (three dimensions) and the shift, P(cosine <= v) =
/// p:
///   P(cosine <= v) = Phi(-s) + v exp(-s^2 (1 - v^2) / 2) Phi(s v),  s = |shift|
/// whose derivative is the integral of R^2 over the ray, radial(0, s v), times the normal factor across it.
double cosine_within(double p, double s) {
  const auto below = [&](double v) {
    return stats::normal_upper_tail(s) + v * std::exp(-s * s * (1 - v * v) / 2) * stats::normal_upper_tail(-s * v);
  };
  double lo = -1, hi = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = (lo + hi) / 2;
    (below(middle) < p ? lo : hi) = middle;
  }
  return (lo + hi) / 2;
}

}  // namespace

LinearRates linear_rates(const ParityModel& m, const Eigen::VectorXd& shift, Eigen::Index number, double critical) {
  const double nan = kNaN;
  if (m.columns.rows() != 3) return {nan, nan};
  std::vector<Eigen::Vector3d> tests;
  const Eigen::VectorXd size = sensitivities(m);
  for (Eigen::Index i = 0; i < m.observations(); ++i)
    if (size[i] > 0) tests.push_back(m.columns.col(i) / size[i]);
  const Eigen::Vector3d own = size[number] > 0 ? Eigen::Vector3d(m.columns.col(number) / size[number])
                                               : Eigen::Vector3d(Eigen::Vector3d::Zero());

  // Polar coordinates about the shift, in rings of equal probability: the weights add up to one exactly, and the share
  // of a ray beyond the critical value is a probability, so no rate can leave [0, 1].
  const double size_of_shift = shift.norm();
  const Eigen::Vector3d towards = size_of_shift > 0 ? Eigen::Vector3d(shift / size_of_shift) : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d x = towards.unitOrthogonal(), y = towards.cross(x);
  constexpr int kPolar = 400, kAround = 240;
  LinearRates rates;
  for (int p = 0; p < kPolar; ++p) {
    const double cosine = cosine_within((p + 0.5) / kPolar, size_of_shift), c = cosine * size_of_shift;
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine)), whole = radial(0, c);
    for (int a = 0; a < kAround; ++a) {
      const double around = (a + 0.5) * 2 * kPi / kAround;
      const Eigen::Vector3d d = cosine * towards + sine * (std::cos(around) * x + std::sin(around) * y);
      double largest = 0;
      for (const Eigen::Vector3d& test : tests) largest = std::max(largest, std::abs(test.dot(d)));
      if (!(largest > 0)) continue;
      const double share = std::min(1.0, radial(critical / largest, c) / whole) / (kPolar * kAround);
      rates.any += share;
      if (std::abs(own.dot(d)) >= largest * (1 - 1e-9)) rates.identified += share;
    }
  }
  rates.any = std::min(rates.any, 1.0);  // the sum of 96,000 shares rounds
  rates.identified = std::min(rates.identified, rates.any);
  return rates;
}

}  // namespace surveymc::reliability
