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

/// Where searches may start: the stations from `first` on, and points within legs that are longer than kPiece. Two legs
/// that curve may come near each other more than once.
std::vector<PathPoint> starts_of(const WellPath& path, std::size_t first) {
  constexpr double kPiece = 50;  // m
  constexpr double kMostPieces = 200;
  std::vector<PathPoint> out{path.at_station(first)};
  for (std::size_t k = first; k + 1 < path.stations(); ++k) {
    const double pieces = std::min(kMostPieces, std::ceil((path.md(k + 1) - path.md(k)) / kPiece));
    for (double i = 1; i < pieces; ++i) out.push_back(path.at(k, i / pieces));
    out.push_back(path.at_station(k + 1));
  }
  return out;
}

/// Half of the longer gap beside every start: so far a point may be from the nearest of them.
std::vector<double> half_gaps(const std::vector<PathPoint>& starts) {
  std::vector<double> out;
  for (std::size_t k = 0; k < starts.size(); ++k)
    out.push_back(std::max(k > 0 ? starts[k].md - starts[k - 1].md : 0.0,
                           k + 1 < starts.size() ? starts[k + 1].md - starts[k].md : 0.0) /
                  2);
  return out;
}

/// Both paths from their first stations on, and beta of two of their points.
struct BothPaths {
  const WellPath &reference, &offset;
  std::size_t first_reference, first_offset;
  const RelativeCovariance& covariance;
  double radii;

  TouchingPair pair(const PathPoint& a, const PathPoint& b) const {
    return {a, b, touching_beta(b.position - a.position, covariance(a, b), radii)};
  }
  TouchingPair at(double reference_md, double offset_md) const {
    const auto on = [](const WellPath& path, std::size_t first, double md) {
      return path.at(std::clamp(md, path.md(first), path.md(path.stations() - 1)));
    };
    return pair(on(reference, first_reference, reference_md), on(offset, first_offset, offset_md));
  }
  /// From one point to the closest of the other path, and back: where the wells pass each other.
  TouchingPair passing(PathPoint a) const {
    constexpr int kTurns = 20;
    PathPoint b = offset.closest(a.position, first_offset).point;
    for (int turn = 0; turn < kTurns; ++turn) {
      a = reference.closest(b.position, first_reference).point;
      b = offset.closest(a.position, first_offset).point;
    }
    return pair(a, b);
  }
  /// A compass search in both depths.
  TouchingPair refined(TouchingPair best, double step) const {
    for (int tries = 0; step > kDepthError && tries < 200; ++tries) {
      TouchingPair next = best;
      for (const auto& [x, y] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}) {
        const TouchingPair other = at(best.reference.md + x * step, best.offset.md + y * step);
        if (other.beta < next.beta * (1 - 1e-12)) next = other;
      }
      if (next.beta < best.beta)
        best = next;
      else
        step /= 2;
    }
    return best;
  }
};

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
  const BothPaths paths{reference, offset, first_reference, first_offset, covariance, radii};
  const std::vector<PathPoint> a = starts_of(reference, first_reference), b = starts_of(offset, first_offset);
  const std::vector<double> half_a = half_gaps(a), half_b = half_gaps(b);
  const std::size_t rows = a.size(), columns = b.size();
  // Bounds by the trace first, of the starts and of all points that are nearest to them: the search by eigenvalues is
  // for the pairs that may be among the least.
  std::vector<double> bound(rows * columns), bound_between(rows * columns);
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const std::size_t at = i * columns + j;
      const double trace = covariance(a[i], b[j]).trace(), gap = (b[j].position - a[i].position).norm() - radii;
      const auto bound_of = [&](double apart) {
        return apart <= 0 ? 0 : trace > 0 ? apart / std::sqrt(trace) : kInfinity;
      };
      bound[at] = bound_of(gap);
      bound_between[at] = bound_of(gap - half_a[i] - half_b[j]);
      order.emplace_back(bound[at], at);
    }
  std::sort(order.begin(), order.end());
  double least = kInfinity;
  std::vector<double> beta = bound;
  std::vector<bool> exact(beta.size());
  const double margin = keep + 1;  // refining may lower what starts have
  for (const auto& [lower, at] : order) {
    if (lower > least + margin) break;
    beta[at] = paths.pair(a[at / columns], b[at % columns]).beta;
    exact[at] = true;
    least = std::min(least, beta[at]);
  }
  const auto is_least = [&](const std::vector<double>& value, std::size_t i, std::size_t j) {
    const double here = value[i * columns + j];
    for (std::size_t k = i == 0 ? 0 : i - 1; k <= std::min(i + 1, rows - 1); ++k)
      for (std::size_t l = j == 0 ? 0 : j - 1; l <= std::min(j + 1, columns - 1); ++l) {
        const double other = value[k * columns + l];
        // Of equal ones the shallowest.
        if (other < here || (other == here && (k < i || (k == i && l < j)))) return false;
      }
    return true;
  };
  std::vector<TouchingPair> out;
  // Searches from a pair of starts, and keeps what is farther than `apart` along either well from what is known.
  const auto search = [&](const TouchingPair& start, std::size_t i, std::size_t j, double apart) {
    constexpr double kStep = 16;  // m
    const TouchingPair best = paths.refined(start, std::max({kStep, half_a[i], half_b[j]}));
    if (!std::isfinite(best.beta)) return;
    least = std::min(least, best.beta);
    const bool is_known = std::any_of(out.begin(), out.end(), [&](const TouchingPair& p) {
      return std::abs(p.reference.md - best.reference.md) < apart && std::abs(p.offset.md - best.offset.md) < apart;
    });
    if (!is_known) out.push_back(best);
  };
  const double near = least + margin;
  const auto is_near = [&](std::size_t at) { return exact[at] && std::isfinite(beta[at]) && beta[at] <= near; };
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j)
      if (is_near(i * columns + j) && is_least(beta, i, j)) search({a[i], b[j], beta[i * columns + j]}, i, j, 1);
  // Between starts that are all far from touching the wells may pass each other.
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      if (is_near(i * columns + j) || bound_between[i * columns + j] > least + margin || !is_least(bound, i, j))
        continue;
      const TouchingPair at_starts = paths.pair(a[i], b[j]);
      search(std::isfinite(at_starts.beta) ? at_starts : paths.passing(a[i]), i, j,
             std::max({1.0, half_a[i], half_b[j]}));
    }
  std::stable_sort(out.begin(), out.end(),
                   [](const TouchingPair& x, const TouchingPair& y) { return x.beta < y.beta; });
  while (!out.empty() && (static_cast<int>(out.size()) > most || out.back().beta > out.front().beta + keep))
    out.pop_back();
  return out;
}

}  // namespace surveymc::proximity
