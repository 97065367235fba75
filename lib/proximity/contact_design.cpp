#include "proximity/contact_design.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "base/units.h"
#include "stats/linear_algebra.h"

namespace surveymc::proximity {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNoVariance = 1e-12;  // of the largest eigenvalue

}  // namespace

double touching_beta(const Vector3d& r, const Matrix3d& c, double radii, Vector3d* q) {
  if (r.norm() <= radii) {
    if (q != nullptr) *q = r;
    return 0;
  }
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
  eigen.computeDirect(c);
  const Vector3d w = eigen.eigenvalues(), along = eigen.eigenvectors().transpose() * r;
  const double least = kNoVariance * w.maxCoeff();
  double fixed = 0;
  for (int i = 0; i < 3; ++i)
    if (!(w[i] > least)) fixed += along[i] * along[i];
  if (!(w.maxCoeff() > 0) || fixed >= radii * radii) return kInfinity;
  const auto at = [&](double l) {
    Vector3d x;
    for (int i = 0; i < 3; ++i) x[i] = w[i] > least ? along[i] / (1 + l * w[i]) : along[i];
    return x;
  };
  double lo = 0, hi = 1 / w.maxCoeff();
  while (at(hi).norm() > radii) lo = hi, hi *= 4;
  for (int step = 0; step < 60 && hi - lo > 1e-14 * hi; ++step) {
    const double middle = (lo + hi) / 2;
    (at(middle).norm() > radii ? lo : hi) = middle;
  }
  const Vector3d x = at(hi);
  double squares = 0;
  for (int i = 0; i < 3; ++i)
    if (w[i] > least) squares += (along[i] - x[i]) * (along[i] - x[i]) / w[i];
  if (q != nullptr) *q = eigen.eigenvectors() * x;
  return std::sqrt(squares);
}

Eigen::VectorXd design_of(const Eigen::Matrix3Xd& j, const Vector3d& r, const Vector3d& q) {
  const auto eigen = stats::symmetric_eigen(Matrix3d(j * j.transpose()));
  Vector3d x = Vector3d::Zero();
  for (int i = 0; i < 3; ++i)
    if (eigen.values[i] > kNoVariance * eigen.values[2])
      x += eigen.vectors.col(i) * (eigen.vectors.col(i).dot(r - q) / eigen.values[i]);
  return -(j.transpose() * x);
}

std::vector<TouchingPair> touching_pairs(const WellPath& reference, std::size_t first_reference, const WellPath& offset,
                                         std::size_t first_offset, const RelativeCovariance& covariance, double radii,
                                         double keep, int most) {
  const std::size_t rows = reference.stations() - first_reference, columns = offset.stations() - first_offset;
  const auto beta_of = [&](const PathPoint& a, const PathPoint& b) {
    return touching_beta(b.position - a.position, covariance(a, b), radii);
  };
  std::vector<PathPoint> a, b;
  for (std::size_t i = 0; i < rows; ++i) a.push_back(reference.at_station(first_reference + i));
  for (std::size_t j = 0; j < columns; ++j) b.push_back(offset.at_station(first_offset + j));
  // A bound by the trace first: the search by eigenvalues is for the pairs that may be among the least.
  std::vector<double> beta(rows * columns);
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const double trace = covariance(a[i], b[j]).trace();
      const double gap = std::max(0.0, (b[j].position - a[i].position).norm() - radii);
      const double bound = gap == 0 ? 0 : trace > 0 ? gap / std::sqrt(trace) : kInfinity;
      beta[i * columns + j] = bound;
      order.emplace_back(bound, i * columns + j);
    }
  std::sort(order.begin(), order.end());
  double least = kInfinity;
  std::vector<bool> exact(beta.size());
  const double margin = keep + 1;  // refining may lower what stations have
  for (const auto& [bound, at] : order) {
    if (bound > least + margin) break;
    beta[at] = beta_of(a[at / columns], b[at % columns]);
    exact[at] = true;
    least = std::min(least, beta[at]);
  }
  if (!std::isfinite(least)) return {};
  std::vector<TouchingPair> out;
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const double here = beta[i * columns + j];
      if (!exact[i * columns + j] || here > least + margin) continue;
      bool is_least = true;
      for (std::size_t k = i == 0 ? 0 : i - 1; k <= std::min(i + 1, rows - 1); ++k)
        for (std::size_t l = j == 0 ? 0 : j - 1; l <= std::min(j + 1, columns - 1); ++l) {
          const double other = beta[k * columns + l];
          // Of equal ones the shallowest.
          if (other < here || (other == here && (k < i || (k == i && l < j)))) is_least = false;
        }
      if (!is_least) continue;
      // A compass search in both depths.
      TouchingPair best{a[i], b[j], here};
      const auto clamp = [](const WellPath& path, std::size_t first, double md) {
        return std::clamp(md, path.md(first), path.md(path.stations() - 1));
      };
      double step = 16;
      for (int tries = 0; step > kDepthError && tries < 200; ++tries) {
        TouchingPair next = best;
        for (const auto& [x, y] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}) {
          const PathPoint p = reference.at(clamp(reference, first_reference, best.reference.md + x * step)),
                          q = offset.at(clamp(offset, first_offset, best.offset.md + y * step));
          const double value = beta_of(p, q);
          if (value < next.beta * (1 - 1e-12)) next = {p, q, value};
        }
        if (next.beta < best.beta)
          best = next;
        else
          step /= 2;
      }
      const bool is_known = std::any_of(out.begin(), out.end(), [&](const TouchingPair& p) {
        return std::abs(p.reference.md - best.reference.md) < 1 && std::abs(p.offset.md - best.offset.md) < 1;
      });
      if (!is_known) out.push_back(best);
    }
  std::stable_sort(out.begin(), out.end(),
                   [](const TouchingPair& x, const TouchingPair& y) { return x.beta < y.beta; });
  while (!out.empty() && (static_cast<int>(out.size()) > most || out.back().beta > out.front().beta + keep))
    out.pop_back();
  return out;
}

}  // namespace surveymc::proximity
