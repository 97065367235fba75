#include "proximity/separation.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "base/units.h"
#include "stats/linear_algebra.h"

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
  const auto eigen = stats::symmetric_eigen(c);
  const double largest = eigen.values[2];
  Whitened w;
  for (int i = 2; i >= 0; --i) {
    const double variance = eigen.values[i];
    const Vector3d axis = eigen.vectors.col(i);
    if (variance > 0 && variance > kSingular * largest)
      w.transform.row(w.rank++) = axis.transpose() / std::sqrt(variance);
    else if (std::abs(axis.dot(d)) > kLeavesRange * d.norm())
      w.is_in_range = false;
  }
  return w;
}

/// Lower L with C = L L', where C is so far from singular that no eigenvalue can be below kSingular of the largest:
/// the smallest is at least det / trace^2.
struct Factor {
  bool is_regular = false;
  double l00 = 0, l10 = 0, l11 = 0, l20 = 0, l21 = 0, l22 = 0;

  explicit Factor(const Matrix3d& c) {
    constexpr double kFarFromSingular = 1e-13;  // > kSingular
    const double trace = c.trace();
    l00 = std::sqrt(c(0, 0));
    l10 = c(1, 0) / l00;
    l20 = c(2, 0) / l00;
    l11 = std::sqrt(c(1, 1) - l10 * l10);
    l21 = (c(2, 1) - l20 * l10) / l11;
    l22 = std::sqrt(c(2, 2) - l20 * l20 - l21 * l21);
    const double root = l00 * l11 * l22;
    is_regular = root * root > kFarFromSingular * trace * trace * trace;  // false if one is no number
  }
  /// L^-1 v
  Vector3d solve(const Vector3d& v) const {
    const double x = v[0] / l00, y = (v[1] - l10 * x) / l11;
    return {x, y, (v[2] - l20 * x - l21 * y) / l22};
  }
};

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

/// The same for a whitened A (eigenvalues a_i in [0, 1]) and z = whitened d, without its eigenvectors:
///   K(l) = l (1 - l) z.w,  w = N^-1 z,  N = (1 - l) A + l B,  B = 1 - A,
///   K' = w.((1 - l)^2 A - l^2 B) w,  K'' = -2 w.(A B N^-1) w
/// Negative where the maximum is so near an end that N is nearly singular.
double largest_factor_squared(const Vector3d& z, const Matrix3d& a) {
  constexpr double kNearEnd = 1e-4;
  const Matrix3d b = Matrix3d::Identity() - a;
  double lo = 0, hi = 1, l = 0.5, value = 0;
  for (int step = 0; step < 40; ++step) {
    if (l < kNearEnd || l > 1 - kNearEnd) return -1;
    const Matrix3d inverse = ((1 - l) * a + l * b).inverse();
    const Vector3d w = inverse * z, aw = a * w, bw = b * w;
    value = l * (1 - l) * z.dot(w);
    const double slope = (1 - l) * (1 - l) * w.dot(aw) - l * l * w.dot(bw), curvature = -2 * aw.dot(b * (inverse * w));
    (slope > 0 ? lo : hi) = l;
    const double newton = curvature < 0 ? l - slope / curvature : -1;
    const double next = newton > lo && newton < hi ? newton : 0.5 * (lo + hi);
    if (std::abs(next - l) < 1e-8) break;  // the value is flat at its maximum
    l = next;
  }
  return value;
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
  const Factor factor(c);
  if (factor.is_regular) return factor.solve(d).norm();
  const Whitened w = whiten(d, c);
  return w.is_in_range ? (w.transform.topRows(w.rank) * d).norm() : kInfinity;
}

double ellipsoid_factor(const Vector3d& d, const Matrix3d& a, const Matrix3d& b) {
  if (!a.allFinite() || !b.allFinite()) return kNaN;
  if (d.isZero(0)) return 0;
  const Factor factor(a + b);
  if (factor.is_regular) {
    Matrix3d whitened;
    for (int i = 0; i < 3; ++i) whitened.col(i) = factor.solve(a.col(i));
    whitened.transposeInPlace();
    for (int i = 0; i < 3; ++i) whitened.col(i) = factor.solve(whitened.col(i));
    const double squared = largest_factor_squared(factor.solve(d), whitened);
    if (squared >= 0) return std::sqrt(squared);
  }
  const Whitened w = whiten(d, a + b);
  if (!w.is_in_range) return kInfinity;
  Matrix3d own = w.transform * a * w.transform.transpose();
  for (int i = w.rank; i < 3; ++i) own(i, i) = -1;  // coordinates that do not exist come first
  const auto eigen = stats::symmetric_eigen(own);
  const Vector3d y = eigen.vectors.transpose() * (w.transform * d);
  Vector3d y2 = Vector3d::Zero(), share = Vector3d::Zero();
  for (int i = 0; i < w.rank; ++i) {
    y2[i] = y[3 - w.rank + i] * y[3 - w.rank + i];
    share[i] = std::clamp(eigen.values[3 - w.rank + i], 0.0, 1.0);
  }
  return std::sqrt(largest_factor_squared(y2, share, w.rank));
}

}  // namespace surveymc::proximity
