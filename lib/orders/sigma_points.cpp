#include "orders/sigma_points.h"

#include <cmath>

#include "stats/linear_algebra.h"

namespace surveymc::orders {
namespace {

/// `points` (r x n) with their weights, which add up to 1.
SigmaPointMoments moments_of(const Chain& chain, const Centre& centre, const Eigen::MatrixXd& directions,
                             const Eigen::MatrixXd& points, const Eigen::VectorXd& weights) {
  const Eigen::Matrix3Xd f = chain.values(directions * points);
  SigmaPointMoments out;
  out.values = static_cast<int>(points.cols());
  Moments& m = out.moments;
  m.mean = f * weights;
  for (Eigen::Index i = 0; i < f.cols(); ++i) {
    const Eigen::Vector3d off = f.col(i) - m.mean;
    m.covariance += weights[i] * off * off.transpose();
  }
  // The rest: J J' and the trace less what the directions have of them.
  ExpansionParts parts;
  parts.directions = directions;
  const Expansion e = chain.expand(Eigen::VectorXd::Zero(chain.dimension()), centre.state, parts);
  const Eigen::Matrix3Xd within = e.first * directions;
  m.covariance += e.first * e.first.transpose() - within * within.transpose();
  for (std::size_t a = 0; a < 3; ++a)
    m.mean[static_cast<Eigen::Index>(a)] +=
        (e.trace[static_cast<Eigen::Index>(a)] - directions.cwiseProduct(e.along[a]).sum()) / 2;
  out.is_definite =
      m.covariance.allFinite() && stats::symmetric_eigen(m.covariance).values[0] >= -1e-12 * m.covariance.trace();
  return out;
}

const double kRootThree = std::sqrt(3.0);

}  // namespace

SigmaPointMoments unscented(const Chain& chain, const Centre& centre, const Eigen::MatrixXd& directions) {
  const Eigen::Index r = directions.cols();
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(r, 2 * r + 1);
  Eigen::VectorXd weights = Eigen::VectorXd::Constant(2 * r + 1, 1.0 / 6);
  weights[0] = (3.0 - static_cast<double>(r)) / 3;
  for (Eigen::Index i = 0; i < r; ++i) {
    points(i, 1 + 2 * i) = kRootThree;
    points(i, 2 + 2 * i) = -kRootThree;
  }
  return moments_of(chain, centre, directions, points, weights);
}

SigmaPointMoments cubature5(const Chain& chain, const Centre& centre, const Eigen::MatrixXd& directions) {
  const Eigen::Index r = directions.cols(), n = 2 * r * r + 1;
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(r, n);
  Eigen::VectorXd weights(n);
  Eigen::Index at = 1;
  for (Eigen::Index i = 0; i < r; ++i)
    for (const double s : {kRootThree, -kRootThree}) {
      points(i, at) = s;
      weights[at++] = (4.0 - static_cast<double>(r)) / 18;
      for (Eigen::Index j = 0; j < i; ++j)
        for (const double other : {kRootThree, -kRootThree}) {
          points(i, at) = s;
          points(j, at) = other;
          weights[at++] = 1.0 / 36;
        }
    }
  weights[0] = 1 - weights.tail(n - 1).sum();
  return moments_of(chain, centre, directions, points, weights);
}

}  // namespace surveymc::orders
