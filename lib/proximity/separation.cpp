#include "proximity/separation.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "base/units.h"

namespace surveymc::proximity {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kSingular = 1e-14;    // an eigenvalue below this part of the largest is rounding
constexpr double kLeavesRange = 1e-9;  // of the length of d: what lies outside of the range is no rounding

/// d in coordinates in which C is the unit matrix, and the transformation; rows beyond `rank` are not used.
struct Whitened {
  int rank = 0;
  bool is_in_range = true;
  Matrix3d transform = Matrix3d::Zero();
};

Whitened whiten(const Vector3d& d, const Matrix3d& c) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(c);  // eigenvalues ascending
  const double largest = eigen.eigenvalues()[2];
  Whitened w;
  for (int i = 2; i >= 0; --i) {
    const double variance = eigen.eigenvalues()[i];
    const Vector3d axis = eigen.eigenvectors().col(i);
    if (variance > 0 && variance > kSingular * largest)
      w.transform.row(w.rank++) = axis.transpose() / std::sqrt(variance);
    else if (std::abs(axis.dot(d)) > kLeavesRange * d.norm())
      w.is_in_range = false;
  }
  return w;
}

/// Maximum over l in [0, 1] of sum_i y_i^2 h(l; a_i), h = l (1 - l) / (a (1 - l) + b l), b = 1 - a: every h is concave.
double largest_factor_squared(const Vector3d& y2, const Vector3d& a, int rank) {
  constexpr double kEnd = 1e-12;
  double lo = kEnd, hi = 1 - kEnd, l = 0.5;
  const auto value = [&](double at) {
    double sum = 0;
    for (int i = 0; i < rank; ++i) sum += y2[i] * at * (1 - at) / (a[i] * (1 - at) + (1 - a[i]) * at);
    return sum;
  };
  for (int step = 0; step < 60; ++step) {
    double slope = 0, curvature = 0;
    for (int i = 0; i < rank; ++i) {
      const double b = 1 - a[i], q = a[i] * (1 - l) + b * l;
      slope += y2[i] * (a[i] * (1 - l) * (1 - l) - b * l * l) / (q * q);
      curvature -= y2[i] * 2 * a[i] * b / (q * q * q);
    }
    (slope > 0 ? lo : hi) = l;
    const double newton = curvature < 0 ? l - slope / curvature : -1;
    const double next = newton > lo && newton < hi ? newton : 0.5 * (lo + hi);
    // The value is flat at its maximum: an error of 1e-9 in l is below rounding in F.
    if (std::abs(next - l) < 1e-9) break;
    l = next;
  }
  return std::max({value(l), value(kEnd), value(1 - kEnd)});
}

}  // namespace

double pedal_radius(const Matrix3d& c, const Vector3d& u) {
  const double variance = u.dot(c * u);
  return variance > 0 ? std::sqrt(variance) : variance <= 0 ? 0.0 : kNaN;
}

double separation_factor(const SeparationRule& rule, double distance, double radii, double sd_relative) {
  const double free = distance - radii - rule.surface_margin;
  const double size =
      rule.scale_factor * std::sqrt(sd_relative * sd_relative + rule.project_ahead * rule.project_ahead);
  if (size == 0) return free > 0 ? kInfinity : free < 0 ? -kInfinity : 0.0;
  return free / size;
}

double ellipse_separation(const SeparationRule& rule, double distance, double radii, double sd_relative) {
  return distance - radii - rule.scale_factor * sd_relative;
}

double mahalanobis(const Vector3d& d, const Matrix3d& c) {
  if (!c.allFinite()) return kNaN;
  if (d.isZero(0)) return 0;
  const Whitened w = whiten(d, c);
  return w.is_in_range ? (w.transform.topRows(w.rank) * d).norm() : kInfinity;
}

double ellipsoid_factor(const Vector3d& d, const Matrix3d& a, const Matrix3d& b) {
  if (!a.allFinite() || !b.allFinite()) return kNaN;
  if (d.isZero(0)) return 0;
  const Whitened w = whiten(d, a + b);
  if (!w.is_in_range) return kInfinity;
  Matrix3d own = w.transform * a * w.transform.transpose();
  for (int i = w.rank; i < 3; ++i) own(i, i) = -1;  // coordinates that do not exist come first
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(own);
  const Vector3d y = eigen.eigenvectors().transpose() * (w.transform * d);
  Vector3d y2 = Vector3d::Zero(), share = Vector3d::Zero();
  for (int i = 0; i < w.rank; ++i) {
    y2[i] = y[3 - w.rank + i] * y[3 - w.rank + i];
    share[i] = std::clamp(eigen.eigenvalues()[3 - w.rank + i], 0.0, 1.0);
  }
  return std::sqrt(largest_factor_squared(y2, share, w.rank));
}

}  // namespace surveymc::proximity
