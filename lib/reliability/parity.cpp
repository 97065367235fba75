#include "reliability/parity.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Core>

#include "base/units.h"
#include "reliability/station_kernel.h"
#include "stats/linear_algebra.h"

namespace surveymc::reliability {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void clear_untestable(ParityModel& m) {
  for (Index i = 0; i < m.observations(); ++i)
    if (!(m.columns.col(i).squaredNorm() * m.variance[i] >= kLeastRedundancy)) m.columns.col(i).setZero();
}

/// Orthonormal base of the columns of Z, by modified Gram-Schmidt with the largest first. A column that keeps less than
/// 1e-10 of its square is in the span of the others.
MatrixXd base_of(MatrixXd z) {
  const VectorXd size = z.colwise().squaredNorm();
  MatrixXd base(z.rows(), 0);
  for (Index step = 0; step < std::min(z.rows(), z.cols()); ++step) {
    Index best = -1;
    double most = kLeastRedundancy;
    for (Index j = 0; j < z.cols(); ++j)
      if (size[j] > 0 && z.col(j).squaredNorm() / size[j] > most) {
        best = j;
        most = z.col(j).squaredNorm() / size[j];
      }
    if (best < 0) break;
    VectorXd q = z.col(best).normalized();
    if (base.cols() > 0) q = (q - base * (base.transpose() * q)).normalized();  // once more: orthogonal to rounding
    base.conservativeResize(Eigen::NoChange, base.cols() + 1);
    base.rightCols<1>() = q;
    z -= q * (q.transpose() * z);
  }
  return base;
}

MatrixXd columns_of(const ParityModel& m, const std::vector<Index>& observations) {
  MatrixXd z(m.columns.rows(), static_cast<Index>(observations.size()));
  for (std::size_t k = 0; k < observations.size(); ++k) z.col(static_cast<Index>(k)) = m.columns.col(observations[k]);
  return z;
}

GeneralTest test_of(const ParityModel& m, const MatrixXd& z) {
  const MatrixXd base = base_of(z);
  const double r = static_cast<double>(base.cols()), redundancy = static_cast<double>(m.redundancy);
  if (base.cols() == 0) return {kNaN, kNaN, kNaN, 0};
  const VectorXd along = base.transpose() * m.whitened, across = m.whitened - base * along;
  const double t = along.squaredNorm(), rest = across.squaredNorm();
  const bool spent = m.redundancy <= base.cols() || !(rest > 0);
  return {t, spent ? kInfinity : (t / r) / (rest / (redundancy - r)), (t / r) / (m.omega() / redundancy), base.cols()};
}

}  // namespace

ParityModel parity_model(const MatrixXd& conditions, const VectorXd& misclosures, const VectorXd& variance) {
  const MatrixXd covariance = conditions * variance.asDiagonal() * conditions.transpose();
  // Conditions in different units (m/s2, nT, rad): one scale first
  const VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const stats::Cholesky factor = stats::cholesky(scale.asDiagonal() * covariance * scale.asDiagonal());
  if (!factor.positive_definite() || !scale.allFinite())
    throw std::invalid_argument("the covariance of the misclosures is not positive definite");
  ParityModel m;
  m.columns = factor.solve_lower(scale.asDiagonal() * conditions);
  m.whitened = factor.solve_lower(scale.cwiseProduct(misclosures));
  m.variance = variance;
  m.redundancy = conditions.rows();
  clear_untestable(m);
  return m;
}

ParityModel without(const ParityModel& model, const std::vector<Index>& observations) {
  ParityModel m = model;
  const MatrixXd base = base_of(columns_of(model, observations));
  m.whitened -= base * (base.transpose() * m.whitened);
  m.columns -= base * (base.transpose() * m.columns);
  m.redundancy -= base.cols();
  for (const Index i : observations) m.columns.col(i).setZero();
  if (m.redundancy == 0) {
    m.whitened.setZero();
    m.columns.setZero();
  }
  clear_untestable(m);
  return m;
}

VectorXd redundancy_numbers(const ParityModel& m) {
  return m.columns.colwise().squaredNorm().transpose().cwiseProduct(m.variance);
}

VectorXd sensitivities(const ParityModel& m) { return m.columns.colwise().norm(); }

VectorXd w_statistics(const ParityModel& m) {
  const VectorXd along = m.columns.transpose() * m.whitened, size = sensitivities(m);
  return (size.array() > 0).select(along.cwiseQuotient(size), 0);
}

VectorXd estimated_errors(const ParityModel& m) {
  const VectorXd along = m.columns.transpose() * m.whitened, squares = m.columns.colwise().squaredNorm();
  return (squares.array() > 0).select(along.cwiseQuotient(squares), kNaN);
}

MatrixXd test_correlations(const ParityModel& m) {
  const VectorXd size = sensitivities(m);
  MatrixXd unit = m.columns;
  for (Index i = 0; i < unit.cols(); ++i)
    if (size[i] > 0) unit.col(i) /= size[i];
  MatrixXd rho = unit.transpose() * unit;
  rho.diagonal().setOnes();
  return rho.cwiseMin(1.0).cwiseMax(-1.0);
}

GeneralTest general_test(const ParityModel& m, const std::vector<Index>& observations) {
  return test_of(m, columns_of(m, observations));
}

GeneralTest general_test(const ParityModel& m, const MatrixXd& directions) {
  return test_of(m, m.columns * directions);
}

VectorXd pope_statistics(const ParityModel& m) {
  const double sigma0 = std::sqrt(m.omega() / static_cast<double>(m.redundancy));
  return sigma0 > 0 ? VectorXd(w_statistics(m) / sigma0) : VectorXd::Constant(m.observations(), kNaN);
}

WeakestCombination weakest_combination(const ParityModel& m, const std::vector<Index>& observations, double lambda0) {
  MatrixXd z = columns_of(m, observations);
  for (std::size_t k = 0; k < observations.size(); ++k)
    z.col(static_cast<Index>(k)) *= std::sqrt(m.variance[observations[k]]);
  const stats::SymmetricEigen eigen = stats::symmetric_eigen(z.transpose() * z);
  VectorXd direction = eigen.vectors.col(0);
  Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  if (direction[largest] < 0) direction = -direction;
  const double information = eigen.values[0];
  return {information < kLeastRedundancy ? kInfinity : lambda0 / std::sqrt(information), direction};
}

double detectable_along(const ParityModel& m, const VectorXd& direction, double lambda0) {
  const double size = (m.columns * direction).norm();
  return size > 0 ? lambda0 / size : kInfinity;
}

}  // namespace surveymc::reliability
