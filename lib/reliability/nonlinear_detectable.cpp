#include "reliability/nonlinear_detectable.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Cholesky>

#include "base/units.h"
#include "reliability/adjustment.h"
#include "reliability/conditions.h"
#include "reliability/levenberg.h"

namespace surveymc::reliability {
namespace {

/// The computation of adjust() with all memory on the stack, because maps need it a million times. One station, or two
/// of which the second stands for all others of a shared adjustment; observations in the order of StationReadings
/// (adjustment.h). kFull: the shared quantities have a full covariance instead of variances.
template <int kStations, bool kSystematic, bool kFull = false>
class ErrorShift {
  static constexpr int kReferencesAt = 6 * kStations, kBiasesAt = kReferencesAt + 3, kScalesAt = kBiasesAt + 6;
  static constexpr int kShared = kSystematic ? 15 : 3, kCount = kReferencesAt + kShared, kConditions = 3 * kStations;
  static constexpr int kBz = static_cast<int>(index_of(Observation::bz));
  using Values = Eigen::Matrix<double, kCount, 1>;
  using Misfits = Eigen::Matrix<double, kConditions, 1>;
  using Jacobian = Eigen::Matrix<double, kConditions, kCount>;
  using Covariance = Eigen::Matrix<double, kConditions, kConditions>;

 public:
  ErrorShift(const AdjustmentModel& model, const survey::Attitude& at, std::size_t observation,
             const Eigen::MatrixXd& shared = {})
      : model_(model) {
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
    if constexpr (kFull) {
      shared_ = shared;
      variance_.template tail<kShared>() = shared_.diagonal();
    }
    in_error_ = static_cast<int>(observation) + (observation < kReadings ? 0 : kReferencesAt - 6);
    without_bz_ = model.mode == AdjustmentMode::sse_axial;
  }

  double sd() const { return std::sqrt(variance_[in_error_]); }

  struct Solution {
    TestShift shift;
    Values adjusted;
  };

  TestShift operator()(double nabla) const { return solve(nabla).shift; }

  Solution solve(double nabla) const {
    constexpr int kMost = 60;
    Values y = truth_;
    y[in_error_] += nabla;
    Values adjusted = y;
    for (int i = 0; i < kMost; ++i) {
      const Step s = step_from(adjusted, y);
      double moved = 0;
      for (int k = 0; k < kCount; ++k)
        if (variance_[k] > 0) moved = std::max(moved, std::abs(s.next[k] - adjusted[k]) / std::sqrt(variance_[k]));
      adjusted = s.next;
      if (moved <= 1e-8) return {s.shift, adjusted};
    }
    const Minimum m = minimum(y);
    if (!m.converged) return {{kNaN, kNaN}, y};
    adjusted.template head<kReferencesAt>() = m.adjusted.template head<kReferencesAt>();
    adjusted.template tail<kShared>().head(m.adjusted.size() - kReferencesAt) =
        m.adjusted.tail(m.adjusted.size() - kReferencesAt);
    return {step_from(adjusted, y).shift, adjusted};
  }

  /// Readings of the station in error, less the systematic terms.
  static std::array<double, kReadings> corrected(const Values& y, int k = 0) {
    std::array<double, kReadings> r;
    for (int i = 0; i < 6; ++i) {
      r[static_cast<std::size_t>(i)] = y[6 * k + i];
      if constexpr (kSystematic) r[static_cast<std::size_t>(i)] -= y[kBiasesAt + i] + y[kScalesAt + i] * y[6 * k + i];
    }
    return r;
  }

  /// Estimated errors of the shared quantities: of references observed less adjusted, and the systematic terms.
  Eigen::VectorXd shared_errors(const Values& adjusted, double nabla) const {
    Values y = truth_;
    y[in_error_] += nabla;
    Eigen::Matrix<double, kShared, 1> z = adjusted.template tail<kShared>();
    z.template head<3>() = y.template segment<3>(kReferencesAt) - z.template head<3>();
    return z;
  }

 private:
  /// One Gauss-Newton step, and the tests of the linear problem that it solves.
  struct Step {
    Values next;
    TestShift shift;
  };
  Step step_from(const Values& adjusted, const Values& y) const {
    Misfits w;
    Jacobian jacobian;
    linearise(adjusted, w, jacobian);
    w += jacobian * (y - adjusted);
    Eigen::Matrix<double, kCount, kConditions> weighted = variance_.asDiagonal() * jacobian.transpose();
    if constexpr (kFull)
      weighted.template bottomRows<kShared>() = shared_ * jacobian.template rightCols<kShared>().transpose();
    const Covariance covariance = jacobian * weighted;
    const Misfits scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::LLT<Covariance> factor(scale.asDiagonal() * covariance * scale.asDiagonal());
    Misfits t = factor.matrixL().solve(scale.cwiseProduct(w));
    Misfits own = factor.matrixL().solve(scale.cwiseProduct(jacobian.col(in_error_)));
    double bz = 0;
    if (without_bz_) {
      const double sd_z = std::sqrt(variance_[kBz]);
      const Misfits z = factor.matrixL().solve(scale.cwiseProduct(jacobian.col(kBz) * sd_z));
      if (z.squaredNorm() > 1e-10) {  // kLeastRedundancy
        bz = z.dot(t) / z.squaredNorm() * sd_z;
        t -= z * (bz / sd_z);
        own -= z * (z.dot(own) / z.squaredNorm());
      }
    }
    Step s;
    s.next = y - weighted * (scale.asDiagonal() * factor.matrixU().solve(t));
    if (without_bz_) s.next[kBz] = y[kBz] - bz;
    const double size = own.norm();
    s.shift = {t.norm(), size * sd() > 1e-5 ? std::abs(own.dot(t)) / size : 0};  // r of 1e-10, kLeastRedundancy
    return s;
  }

  Minimum minimum(const Values& y) const {
    StationReadings readings;
    for (int k = 0; k < kStations; ++k) {
      readings.readings.emplace_back();
      for (int i = 0; i < 6; ++i) readings.readings.back()[static_cast<std::size_t>(i)] = y[6 * k + i];
    }
    for (int j = 0; j < 3; ++j) readings.references[static_cast<std::size_t>(j)] = y[kReferencesAt + j];
    AdjustmentModel m = model_;
    m.rotational_shot = false;
    std::optional<Eigen::MatrixXd> shared;
    if constexpr (kFull) shared = shared_;
    return minimum_of_omega(m, readings, variance_, {}, shared);
  }

  /// Conditions at the observations `y`, and their derivatives. Corrected reading = reading - bias - scale reading.
  static void linearise(const Values& y, Misfits& values, Jacobian& jacobian) {
    jacobian.setZero();
    for (int k = 0; k < kStations; ++k) {
      const Conditions c = station_conditions(corrected(y, k).data());
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

  AdjustmentModel model_;
  Values truth_, variance_;
  Eigen::Matrix<double, kFull ? kShared : 0, kFull ? kShared : 0> shared_;
  int in_error_;
  bool without_bz_;
};

void check_observed(const AdjustmentModel& model, std::size_t observation) {
  if (!is_observed(model.mode, observation))
    throw std::invalid_argument(observation_names()[observation] + " is not observed");
}

/// Calls use(shift) with the smallest adjustment that is equal to that of all stations.
template <class Use>
auto with_shift(const AdjustmentModel& model, const survey::Attitude& at, std::size_t observation, const Use& use) {
  check_observed(model, observation);
  const bool shared = model.mode == AdjustmentMode::mse_shared, systematic = shared && model.systematic_terms;
  const bool alone = !shared || model.stations == 1;
  if (alone)
    return systematic ? use(ErrorShift<1, true>(model, at, observation))
                      : use(ErrorShift<1, false>(model, at, observation));
  return systematic ? use(ErrorShift<2, true>(model, at, observation))
                    : use(ErrorShift<2, false>(model, at, observation));
}

/// Smallest size whose shift reaches lambda0. size(nabla) -> shift.
template <class Size>
double first_found(const Size& size, double sd, double lambda0, double tolerance) {
  constexpr double kStep = 1.1, kMostSd = 1e4;
  // r <= 1: no error below lambda0 sd is found, but nonlinearity may lower this bound a little
  double below = 0, above = 0.5 * lambda0 * sd, missing = -lambda0, excess = size(above) - lambda0;
  while (above < kMostSd * sd && !(excess >= 0)) {
    below = above;
    missing = excess;
    above *= kStep;
    excess = size(above) - lambda0;
  }
  if (!(above < kMostSd * sd)) return kInfinity;
  // Regula falsi that halves the value of an end that stays (Illinois), and halves the bracket where that is slow: the
  // shift may have kinks
  int kept = 0;
  for (int i = 0; i < 100 && above - below > tolerance * above; ++i) {
    const bool halve = i % 4 == 3 || std::isnan(missing);
    double middle = halve ? (below + above) / 2 : below - missing * (above - below) / (excess - missing);
    // Not nearer to an end than the tolerance: the bracket then closes on the other side
    const double margin = 0.4 * tolerance * above;
    middle = std::min(std::max(middle, below + margin), above - margin);
    const double value = size(middle) - lambda0;
    if (value >= 0) {
      above = middle;
      excess = value;
      if (kept == 1) missing /= 2;
      kept = 1;
    } else {
      below = middle;
      missing = value;
      if (kept == -1) excess /= 2;
      kept = -1;
    }
  }
  return above;
}

template <class Shift>
DetectedError detected_in(const Shift& shift, double lambda0, int sign, DetectedBy test) {
  DetectedError e;
  e.size = sign * first_found([&](double size) { return shift(sign * size).by(test); }, shift.sd(), lambda0, 1e-8);
  if (!std::isfinite(e.size)) return e;
  const auto solution = shift.solve(e.size);
  const auto y = Shift::corrected(solution.adjusted);
  e.down = {y[0], y[1], y[2]};
  e.field = {y[3], y[4], y[5]};
  e.shared_errors = shift.shared_errors(solution.adjusted, e.size);
  return e;
}

}  // namespace

TestShift error_shift(const AdjustmentModel& model, const survey::Attitude& at, std::size_t observation, double nabla) {
  return with_shift(model, at, observation, [&](const auto& shift) { return shift(nabla); });
}

double nonlinear_detectable_error(const AdjustmentModel& model, const survey::Attitude& at, std::size_t observation,
                                  double lambda0, int sign, DetectedBy test) {
  return with_shift(model, at, observation, [&](const auto& shift) {
    return sign * first_found([&](double size) { return shift(sign * size).by(test); }, shift.sd(), lambda0, 1e-10);
  });
}

DetectedError detected_error(const StationInWell& s, std::size_t observation, double lambda0, int sign,
                             DetectedBy test) {
  check_observed(s.model, observation);
  if (s.shared.size() == 0) return detected_in(ErrorShift<1, false>(s.model, s.at, observation), lambda0, sign, test);
  if (s.shared.rows() == 3)
    return detected_in(ErrorShift<1, false, true>(s.model, s.at, observation, s.shared), lambda0, sign, test);
  return detected_in(ErrorShift<1, true, true>(s.model, s.at, observation, s.shared), lambda0, sign, test);
}

DetectedError detected_error(const AdjustmentModel& model, const survey::Attitude& at, std::size_t observation,
                             double lambda0, int sign, DetectedBy test) {
  return with_shift(model, at, observation, [&](const auto& shift) { return detected_in(shift, lambda0, sign, test); });
}

AngleEffects angle_effects(const survey::Attitude& at, const DetectedError& e) {
  const double none = kNaN;
  if (!std::isfinite(e.size)) return {e.size, e.size, e.size};
  const survey::Attitude with = survey::attitude_from_fields(survey::from_eigen(e.down), survey::from_eigen(e.field));
  const auto turned = [](double angle) { return std::remainder(angle, 2 * kPi); };
  const bool vertical = std::abs(std::sin(at.inclination)) < 1e-12;
  return {with.inclination - at.inclination, vertical ? none : turned(with.toolface - at.toolface),
          vertical ? none : turned(with.azimuth - at.azimuth)};
}

}  // namespace surveymc::reliability
