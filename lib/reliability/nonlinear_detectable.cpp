#include "reliability/nonlinear_detectable.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <Eigen/Cholesky>

#include "reliability/adjustment.h"
#include "reliability/conditions.h"

namespace surveymc {
namespace {

/// What adjust() does, on the stack: maps need it a million times. One station, or two of which the second stands for
/// all others of a shared adjustment; observations in the order of StationReadings (adjustment.h).
template <int kStations, bool kSystematic>
class ErrorShift {
  static constexpr int kReferencesAt = 6 * kStations, kBiasesAt = kReferencesAt + 3, kScalesAt = kBiasesAt + 6;
  static constexpr int kCount = kBiasesAt + (kSystematic ? 12 : 0), kConditions = 3 * kStations;
  static constexpr int kBz = static_cast<int>(index_of(Observation::bz));
  using Values = Eigen::Matrix<double, kCount, 1>;
  using Misfits = Eigen::Matrix<double, kConditions, 1>;
  using Jacobian = Eigen::Matrix<double, kConditions, kCount>;
  using Covariance = Eigen::Matrix<double, kConditions, kConditions>;

 public:
  ErrorShift(const AdjustmentModel& model, const Attitude& at, std::size_t observation) {
    const Observations y = true_observations(at, model.field), v = observation_variances(model, y);
    truth_.setZero();
    for (int k = 0; k < kStations; ++k)
      for (int i = 0; i < 6; ++i) {
        truth_[6 * k + i] = y[static_cast<std::size_t>(i)];
        variance_[6 * k + i] = v[static_cast<std::size_t>(i)] / (k == 0 ? 1 : model.stations - 1);
      }
    for (int j = 0; j < 3; ++j) {
      truth_[kReferencesAt + j] = y[static_cast<std::size_t>(6 + j)];
      variance_[kReferencesAt + j] = v[static_cast<std::size_t>(6 + j)];
    }
    if constexpr (kSystematic)
      variance_.template tail<12>() = adjustment_variances(model, {{y[0], y[1], y[2], y[3], y[4], y[5]}}).tail<12>();
    in_error_ = static_cast<int>(observation) + (observation < kReadings ? 0 : kReferencesAt - 6);
    without_bz_ = model.mode == AdjustmentMode::sse_axial;
  }

  double sd() const { return std::sqrt(variance_[in_error_]); }

  double operator()(double nabla) const {
    constexpr int kMost = 60;
    Values y = truth_;
    y[in_error_] += nabla;
    Values adjusted = y;
    for (int i = 0; i < kMost; ++i) {
      Misfits w;
      Jacobian jacobian;
      linearise(adjusted, w, jacobian);
      w += jacobian * (y - adjusted);
      const Eigen::Matrix<double, kCount, kConditions> weighted = variance_.asDiagonal() * jacobian.transpose();
      const Covariance covariance = jacobian * weighted;
      const Misfits scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::LLT<Covariance> factor(scale.asDiagonal() * covariance * scale.asDiagonal());
      Misfits t = factor.matrixL().solve(scale.cwiseProduct(w));
      double bz = 0;
      if (without_bz_) {
        const double sd_z = std::sqrt(variance_[kBz]);
        const Misfits z = factor.matrixL().solve(scale.cwiseProduct(jacobian.col(kBz) * sd_z));
        if (z.squaredNorm() > 1e-10) {  // kLeastRedundancy
          bz = z.dot(t) / z.squaredNorm() * sd_z;
          t -= z * (bz / sd_z);
        }
      }
      Values next = y - weighted * (scale.asDiagonal() * factor.matrixU().solve(t));
      if (without_bz_) next[kBz] = y[kBz] - bz;
      double step = 0;
      for (int k = 0; k < kCount; ++k)
        if (variance_[k] > 0) step = std::max(step, std::abs(next[k] - adjusted[k]) / std::sqrt(variance_[k]));
      adjusted = next;
      if (step <= 1e-8) return t.norm();
    }
    return std::numeric_limits<double>::quiet_NaN();
  }

 private:
  /// Conditions at the observations `y`, and their derivatives. Corrected reading = reading - bias - scale reading.
  static void linearise(const Values& y, Misfits& values, Jacobian& jacobian) {
    jacobian.setZero();
    for (int k = 0; k < kStations; ++k) {
      std::array<double, kReadings> corrected;
      for (int i = 0; i < 6; ++i) {
        corrected[static_cast<std::size_t>(i)] = y[6 * k + i];
        if constexpr (kSystematic)
          corrected[static_cast<std::size_t>(i)] -= y[kBiasesAt + i] + y[kScalesAt + i] * y[6 * k + i];
      }
      const Conditions c = station_conditions(corrected.data());
      values.template segment<3>(3 * k) = c.values - y.template segment<3>(kReferencesAt);
      jacobian.template block<3, 6>(3 * k, 6 * k) = c.jacobian;
      jacobian.template block<3, 3>(3 * k, kReferencesAt) = -Eigen::Matrix3d::Identity();
      if constexpr (kSystematic)
        for (int i = 0; i < 6; ++i) {
          jacobian.template block<3, 1>(3 * k, 6 * k + i) *= 1 - y[kScalesAt + i];
          jacobian.template block<3, 1>(3 * k, kBiasesAt + i) = -c.jacobian.col(i);
          jacobian.template block<3, 1>(3 * k, kScalesAt + i) = -y[6 * k + i] * c.jacobian.col(i);
        }
    }
  }

  Values truth_, variance_;
  int in_error_;
  bool without_bz_;
};

/// Calls use(shift) with the smallest adjustment that is the whole one.
template <class Use>
double with_shift(const AdjustmentModel& model, const Attitude& at, std::size_t observation, const Use& use) {
  if (!is_observed(model.mode, observation))
    throw std::invalid_argument(observation_names()[observation] + " is not observed");
  const bool shared = model.mode == AdjustmentMode::mse_shared, systematic = shared && model.systematic_terms;
  const bool alone = !shared || model.stations == 1;
  if (alone)
    return systematic ? use(ErrorShift<1, true>(model, at, observation))
                      : use(ErrorShift<1, false>(model, at, observation));
  return systematic ? use(ErrorShift<2, true>(model, at, observation))
                    : use(ErrorShift<2, false>(model, at, observation));
}

}  // namespace

double error_shift(const AdjustmentModel& model, const Attitude& at, std::size_t observation, double nabla) {
  return with_shift(model, at, observation, [&](const auto& shift) { return shift(nabla); });
}

double nonlinear_detectable_error(const AdjustmentModel& model, const Attitude& at, std::size_t observation,
                                  double lambda0, int sign) {
  constexpr double kStep = 1.1, kMostSd = 1e4;
  return with_shift(model, at, observation, [&](const auto& shift) {
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
  });
}

}  // namespace surveymc
