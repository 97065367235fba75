#include "reliability/nonlinear_detectable.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "reliability/conditions.h"

namespace surveymc {
namespace {

using Matrix39 = Eigen::Matrix<double, 3, kObservations>;
using Vector9 = Eigen::Matrix<double, kObservations, 1>;

/// What adjust() does, for one station and on the stack: maps need it a million times.
class ErrorShift {
 public:
  ErrorShift(const AdjustmentModel& model, const Attitude& at, std::size_t observation) : observation_(observation) {
    const Observations y = true_observations(at, model.field), v = observation_variances(model, y);
    for (std::size_t i = 0; i < kObservations; ++i) {
      truth_[static_cast<Eigen::Index>(i)] = y[i];
      variance_[static_cast<Eigen::Index>(i)] = v[i];
    }
    without_bz_ = model.mode == AdjustmentMode::sse_axial;
  }

  double sd() const { return std::sqrt(variance_[static_cast<Eigen::Index>(observation_)]); }

  double operator()(double nabla) const {
    constexpr int kMost = 60;
    Vector9 y = truth_;
    y[static_cast<Eigen::Index>(observation_)] += nabla;
    Vector9 adjusted = y;
    double omega = 0;
    for (int i = 0; i < kMost; ++i) {
      const Conditions c = station_conditions(adjusted.data());
      Matrix39 jacobian;
      jacobian << c.jacobian, -Eigen::Matrix3d::Identity();
      const Eigen::Vector3d w = c.values - adjusted.tail<3>() + jacobian * (y - adjusted);
      const Eigen::Matrix<double, kObservations, 3> weighted = variance_.asDiagonal() * jacobian.transpose();
      const Eigen::Matrix3d covariance = jacobian * weighted;
      const Eigen::Vector3d scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::LLT<Eigen::Matrix3d> factor(scale.asDiagonal() * covariance * scale.asDiagonal());
      Eigen::Vector3d t = factor.matrixL().solve(scale.cwiseProduct(w));
      double bz = 0;
      if (without_bz_) {
        const double sd_z = std::sqrt(variance_[kBz]);
        const Eigen::Vector3d z = factor.matrixL().solve(scale.cwiseProduct(jacobian.col(kBz) * sd_z));
        if (z.squaredNorm() > 1e-10) {  // kLeastRedundancy
          bz = z.dot(t) / z.squaredNorm() * sd_z;
          t -= z * (bz / sd_z);
        }
      }
      Vector9 next = y - weighted * (scale.asDiagonal() * factor.matrixU().solve(t));
      if (without_bz_) next[kBz] = y[kBz] - bz;
      double step = 0;
      for (Eigen::Index k = 0; k < Vector9::SizeAtCompileTime; ++k)
        if (variance_[k] > 0) step = std::max(step, std::abs(next[k] - adjusted[k]) / std::sqrt(variance_[k]));
      adjusted = next;
      omega = t.squaredNorm();
      if (step <= 1e-8) return std::sqrt(omega);
    }
    return std::numeric_limits<double>::quiet_NaN();
  }

 private:
  static constexpr Eigen::Index kBz = static_cast<Eigen::Index>(index_of(Observation::bz));
  Vector9 truth_, variance_;
  std::size_t observation_;
  bool without_bz_;
};

}  // namespace

double error_shift(const AdjustmentModel& model, const Attitude& at, std::size_t observation, double nabla) {
  return ErrorShift(model, at, observation)(nabla);
}

double nonlinear_detectable_error(const AdjustmentModel& model, const Attitude& at, std::size_t observation,
                                  double lambda0, int sign) {
  constexpr double kStep = 1.1, kMostSd = 1e4;
  const ErrorShift shift(model, at, observation);
  // r <= 1: no error is found below lambda0 sd, but nonlinearity may make it a little easier
  double below = 0, above = 0.5 * lambda0 * shift.sd();
  while (above < kMostSd * shift.sd() && !(shift(sign * above) >= lambda0)) {
    below = above;
    above *= kStep;
  }
  if (!(above < kMostSd * shift.sd())) return sign * std::numeric_limits<double>::infinity();
  for (int i = 0; i < 60 && above - below > 1e-10 * above; ++i) {  // bisection: the shift may have kinks
    const double middle = (below + above) / 2;
    (shift(sign * middle) >= lambda0 ? above : below) = middle;
  }
  return sign * above;
}

}  // namespace surveymc
