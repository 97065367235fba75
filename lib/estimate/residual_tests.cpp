#include "estimate/residual_tests.h"

#include <cassert>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "base/units.h"
#include "stats/linear_algebra.h"

namespace surveymc::estimate {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;

double ResidualTests::variance_factor() const { return redundancy > 0 ? statistic / redundancy : kNaN; }

ResidualTests residual_tests(const std::vector<survey::StationFields>& stations,
                             const std::vector<FieldMisfit>& misfits, const InputErrors& noise) {
  assert(noise.magnetometer > 0 && misfits.size() >= 3);
  const auto n = static_cast<Index>(misfits.size());
  constexpr Index kUnknowns = 8;  // six parameters, two draws of the reference
  const Vector2d reference_sd(noise.total, noise.dip);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * n + 2, kUnknowns);
  Eigen::VectorXd v = Eigen::VectorXd::Zero(2 * n + 2);  // whitened
  std::vector<Matrix2d> whiten;                          // Q_k^-1/2, lower triangular
  for (std::size_t k = 0; k < misfits.size(); ++k) {
    const FieldMisfit& m = misfits[k];
    const Eigen::Vector3d u = survey::to_eigen(stations[k].down_T);
    const Eigen::Matrix<double, 2, 3> by_tilt = m.by_down * (Matrix3d::Identity() - u * u.transpose());
    const Matrix2d by_reference = m.by_reference * reference_sd.asDiagonal();
    Matrix2d q = noise.magnetometer * noise.magnetometer * m.by_magnetometer * m.by_magnetometer.transpose() +
                 noise.down * noise.down * by_tilt * by_tilt.transpose();
    if (noise.reference_per_station) q += by_reference * by_reference.transpose();
    Matrix2d lower = Matrix2d::Zero();  // Cholesky factor of Q_k
    lower(0, 0) = std::sqrt(q(0, 0));
    lower(1, 0) = q(1, 0) / lower(0, 0);
    lower(1, 1) = std::sqrt(q(1, 1) - lower(1, 0) * lower(1, 0));
    whiten.push_back(lower.inverse());
    const auto row = static_cast<Index>(2 * k);
    a.block<2, 6>(row, 0) = whiten[k] * m.by_parameters;
    if (!noise.reference_per_station) a.block<2, 2>(row, 6) = whiten[k] * by_reference;
    v.segment<2>(row) = whiten[k] * m.residual;
  }
  a.bottomRightCorner<2, 2>().setIdentity();
  for (Index c = 0; c < 6; ++c) a.col(c) /= std::max(a.col(c).norm(), std::numeric_limits<double>::min());

  const Eigen::MatrixXd q = stats::orthonormal_columns(a);
  const Eigen::VectorXd left = v - q * (q.transpose() * v);  // whitened M v
  ResidualTests t;
  t.redundancy = static_cast<int>(2 * n - 6);
  t.statistic = t.redundancy > 0 ? left.squaredNorm() : 0;
  for (std::size_t k = 0; k < misfits.size(); ++k) {
    const auto row = static_cast<Index>(2 * k);
    const Eigen::Matrix<double, 2, kUnknowns> own = q.middleRows<2>(row);
    const Matrix2d checked = Matrix2d::Identity() - own * own.transpose();
    const Matrix2d m = whiten[k].transpose() * checked * whiten[k];
    const Matrix2d unchecked = whiten[k].transpose() * whiten[k];
    const Vector2d mv = whiten[k].transpose() * left.segment<2>(row);
    t.pull.push_back(mv);
    t.precision.push_back(m);
    t.w.push_back(Vector2d::Constant(kNaN));
    t.error.push_back(t.w.back());
    t.error_sd.push_back(t.w.back());
    for (Index i = 0; i < 2; ++i) {
      // Below this, M_ii is only rounding of 1 - q q': the parameters absorb any error here.
      if (t.redundancy == 0 || m(i, i) < 1e-10 * unchecked(i, i)) continue;
      t.w[k][i] = mv[i] / std::sqrt(m(i, i));
      t.error[k][i] = mv[i] / m(i, i);
      t.error_sd[k][i] = 1 / std::sqrt(m(i, i));
    }
  }
  return t;
}

DirectionTest direction_test(const ResidualTests& t, std::size_t station, const Vector2d& c) {
  const double information = c.dot(t.precision[station] * c), nan = kNaN;
  // Rounding of 1 - q q', as above.
  if (!(information > 1e-10 * c.squaredNorm() * t.precision[station].trace())) return {nan, nan, nan};
  const double along = c.dot(t.pull[station]);
  return {along / std::sqrt(information), along / information, 1 / std::sqrt(information)};
}

double direction_correlation(const ResidualTests& t, std::size_t station, const Vector2d& a, const Vector2d& b) {
  const Matrix2d& m = t.precision[station];
  return a.dot(m * b) / std::sqrt(a.dot(m * a) * b.dot(m * b));
}

}  // namespace surveymc::estimate
