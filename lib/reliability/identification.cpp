#include "reliability/identification.h"

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

#include "base/units.h"

namespace surveymc {
namespace {

/// Integral of R^2 phi(R - c) over R > from: with x = R - c, (x + c)^2 phi(x) has a closed integral.
double radial(double from, double c) {
  const double x = from - c, density = std::exp(-x * x / 2) / std::sqrt(2 * kPi),
               above = std::erfc(x / std::sqrt(2.0)) / 2;
  return (x + 2 * c) * density + (1 + c * c) * above;
}

}  // namespace

LinearRates linear_rates(const ParityModel& m, const Eigen::VectorXd& shift, Eigen::Index number, double critical) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (m.columns.rows() != 3) return {nan, nan};
  std::vector<Eigen::Vector3d> tests;
  const Eigen::VectorXd size = sensitivities(m);
  for (Eigen::Index i = 0; i < m.observations(); ++i)
    if (size[i] > 0) tests.push_back(m.columns.col(i) / size[i]);
  const Eigen::Vector3d own = size[number] > 0 ? Eigen::Vector3d(m.columns.col(number) / size[number])
                                               : Eigen::Vector3d(Eigen::Vector3d::Zero());

  // Polar coordinates about the shift, where the probability is
  const Eigen::Vector3d towards = shift.norm() > 0 ? Eigen::Vector3d(shift.normalized()) : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d x = towards.unitOrthogonal(), y = towards.cross(x);
  constexpr int kPolar = 400, kAround = 240;
  LinearRates rates;
  for (int p = 0; p < kPolar; ++p) {
    const double polar = (p + 0.5) * kPi / kPolar;
    const double c = std::cos(polar) * shift.norm();
    const double weight = std::sin(polar) * (kPi / kPolar) * (2 * kPi / kAround) / (2 * kPi) *
                          std::exp(-(shift.squaredNorm() - c * c) / 2);
    if (weight < 1e-16) continue;
    for (int a = 0; a < kAround; ++a) {
      const double around = (a + 0.5) * 2 * kPi / kAround;
      const Eigen::Vector3d d =
          std::cos(polar) * towards + std::sin(polar) * (std::cos(around) * x + std::sin(around) * y);
      double largest = 0;
      for (const Eigen::Vector3d& test : tests) largest = std::max(largest, std::abs(test.dot(d)));
      if (!(largest > 0)) continue;
      const double mass = weight * radial(critical / largest, c);
      rates.any += mass;
      if (std::abs(own.dot(d)) >= largest * (1 - 1e-9)) rates.identified += mass;
    }
  }
  return rates;
}

}  // namespace surveymc
