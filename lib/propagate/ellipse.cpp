#include "propagate/ellipse.h"

#include <cmath>

#include <Eigen/Eigenvalues>

#include "base/units.h"

namespace surveymc {

Ellipse ellipse(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance);  // eigenvalues ascending
  Ellipse e;
  const double largest = std::max(0.0, eigen.eigenvalues()[1]), smallest = eigen.eigenvalues()[0];
  e.semi_major = std::sqrt(largest);
  e.semi_minor = smallest > 1e-14 * largest ? std::sqrt(smallest) : 0.0;  // below, it is rounding of the covariance
  e.axes.col(0) = eigen.eigenvectors().col(1);
  e.axes.col(1) = eigen.eigenvectors().col(0);
  e.azimuth = std::atan2(e.axes(1, 0), e.axes(0, 0));
  if (e.azimuth < 0) e.azimuth += kPi;
  if (e.azimuth >= kPi) e.azimuth -= kPi;
  return e;
}

double ellipse_coverage(double k) { return -std::expm1(-k * k / 2); }

}  // namespace surveymc
