#include "reliability/nonlinear_detectable.h"

#include <cmath>
#include <optional>
#include <stdexcept>

#include <Eigen/Core>

#include "base/units.h"
#include "reliability/adjustment.h"
#include "reliability/conditions.h"
#include "reliability/minimum.h"

namespace surveymc::reliability {
namespace {

/// The computation of adjust() with all memory on the stack, because maps need it a million times. One station, or two
/// of which the second stands for all others of a shared adjustment; observations in the order of StationReadings
/// (adjustment.h). A condition has derivatives by the readings of its own station and by what the stations share.
template <int kStations, bool kSystematic>
class ErrorShift {
  static constexpr int kReferencesAt = 6 * kStations, kBiasesAt = kReferencesAt + 3, kScalesAt = kBiasesAt + 6;
  static constexpr int kShared = kSystematic ? 15 : 3, kCount = kReferencesAt + kShared, kConditions = 3 * kStations;
  using Values = std::array<double, kCount>;
  using Misfits = std::array<double, kConditions>;
  using Jacobian = std::array<Values, kConditions>;
  using Square = std::array<Misfits, kConditions>;

 public:
  /// `full`: the shared quantities have the covariance `shared` (3 x 3, or 15 x 15 with systematic terms), not
  /// variances.
  ErrorShift(const AdjustmentModel& model, const survey::Attitude& at, std::size_t observation,
             const Eigen::MatrixXd* full = nullptr)
      : model_(model) {
    const Observations y = true_observations(at, model.field), v = observation_variances(model, y);
    for (int k = 0; k < kStations; ++k)
      for (int i = 0; i < 6; ++i) {
        truth_[at_(6 * k + i)] = y[at_(i)];
        variance_[at_(6 * k + i)] = v[at_(i)] / (k == 0 ? 1 : model.stations - 1);
      }
    for (int j = 0; j < 3; ++j) {
      truth_[at_(kReferencesAt + j)] = y[at_(6 + j)];
      variance_[at_(kReferencesAt + j)] = v[at_(6 + j)];
    }
    if constexpr (kSystematic) {
      const Eigen::VectorXd terms = adjustment_variances(model, {{y[0], y[1], y[2], y[3], y[4], y[5]}}).tail<12>();
      for (int i = 0; i < 12; ++i) variance_[at_(kBiasesAt + i)] = terms[i];
    }
    if (full) {
      covariance_ = *full;
      for (int j = 0; j < kShared; ++j) variance_[at_(kReferencesAt + j)] = covariance_(j, j);
    }
    for (std::size_t k = 0; k < kCount; ++k) inverse_sd_[k] = variance_[k] > 0 ? 1 / std::sqrt(variance_[k]) : 0;
    in_error_ = static_cast<int>(observation) + (observation < kReadings ? 0 : kReferencesAt - 6);
    without_bz_ = model.mode == AdjustmentMode::sse_axial;
  }

  double sd() const { return std::sqrt(variance_[at_(in_error_)]); }

  struct Solution {
    TestShift shift;
    Values adjusted;
  };

  TestShift operator()(double nabla) const { return solve(nabla).shift; }

  Solution solve(double nabla) const {
    constexpr int kMost = 60;
    Values y = truth_;
    y[at_(in_error_)] += nabla;
    Values adjusted = y;
    std::optional<Solution> lost;  // a point at which bz is lost
    for (int i = 0; i < kMost && !lost; ++i) {
      const Step s = step_from(adjusted, y);
      double moved = 0;
      for (std::size_t k = 0; k < kCount; ++k)
        moved = std::max(moved, std::abs(s.next[k] - adjusted[k]) * inverse_sd_[k]);
      adjusted = s.next;
      if (moved > 1e-8) continue;
      if (!s.bz_is_lost) return {s.shift, adjusted};
      lost = {s.shift, adjusted};
    }
    const Minimum m = minimum(y);
    if (!m.converged) return {{kNaN, kNaN}, y};
    // No step moves a bz that is lost, so the steps also end at a saddle. Where no other bz lowers Omega, the point is
    // the minimum: that of `m` has a bz near it, to some digits only, by which the tests there must not be linearised.
    if (lost && !(m.omega < omega_below(lost->shift.general))) return *lost;
    for (Eigen::Index k = 0; k < m.adjusted.size(); ++k) adjusted[static_cast<std::size_t>(k)] = m.adjusted[k];
    return {step_from(adjusted, y).shift, adjusted};
  }

  /// Readings of station `k`, less the systematic terms; the station in error is 0.
  std::array<double, kReadings> corrected(const Values& y, int k = 0) const {
    std::array<double, kReadings> r;
    for (int i = 0; i < 6; ++i) {
      r[at_(i)] = y[at_(6 * k + i)];
      if constexpr (kSystematic) r[at_(i)] -= y[at_(kBiasesAt + i)] + y[at_(kScalesAt + i)] * y[at_(6 * k + i)];
    }
    return r;
  }

  /// Estimated errors of the shared quantities: of references observed less adjusted, and the systematic terms.
  Eigen::VectorXd shared_errors(const Values& adjusted, double nabla) const {
    Eigen::VectorXd z(kShared);
    for (int j = 0; j < kShared; ++j) {
      const int i = kReferencesAt + j;
      const double observed = truth_[at_(i)] + (i == in_error_ ? nabla : 0);
      z[j] = j < 3 ? observed - adjusted[at_(i)] : adjusted[at_(i)];
    }
    return z;
  }

 private:
  static constexpr std::size_t at_(int i) { return static_cast<std::size_t>(i); }

  /// Calls use(j) with the observations that condition `i` has derivatives by, in their order.
  template <class Use>
  void of_condition(int i, const Use& use) const {
    for (int j = 6 * (i / 3); j < 6 * (i / 3) + 6; ++j) use(at_(j));
    for (int j = kReferencesAt; j < kCount; ++j) use(at_(j));
  }

  /// L^-1 (scale b), L lower triangular with 1 / its diagonal.
  Misfits decorrelated(const Square& l, const Misfits& scale, Misfits b) const {
    for (std::size_t i = 0; i < at_(kConditions); ++i) {
      b[i] *= scale[i];
      for (std::size_t k = 0; k < i; ++k) b[i] -= l[i][k] * b[k];
      b[i] *= l[i][i];
    }
    return b;
  }
  double dot(const Misfits& a, const Misfits& b) const {
    double s = 0;
    for (std::size_t i = 0; i < at_(kConditions); ++i) s += a[i] * b[i];
    return s;
  }

  /// One Gauss-Newton step, and the tests of the linear problem that it solves.
  struct Step {
    Values next;
    TestShift shift;
    bool bz_is_lost = false;  ///< to first order no condition depends on bz, so bz stays as it is
  };
  Step step_from(const Values& adjusted, const Values& y) const {
    const std::size_t n = at_(kConditions);
    Misfits w;
    Jacobian jacobian;
    linearise(adjusted, w, jacobian);
    Jacobian weighted;  // rows of (covariance of the observations) x jacobian'
    for (std::size_t i = 0; i < n; ++i) {
      weighted[i].fill(0);
      of_condition(static_cast<int>(i), [&](std::size_t j) {
        w[i] += jacobian[i][j] * (y[j] - adjusted[j]);
        weighted[i][j] = variance_[j] * jacobian[i][j];
      });
      const std::size_t shared = at_(kReferencesAt);
      for (Eigen::Index j = 0; j < covariance_.rows(); ++j) {
        double s = 0;
        for (Eigen::Index k = 0; k < covariance_.cols(); ++k)
          s += covariance_(k, j) * jacobian[i][shared + at_(int(k))];
        weighted[i][shared + at_(int(j))] = s;
      }
    }
    Square covariance;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k <= i; ++k) {
        double s = 0;
        of_condition(static_cast<int>(i), [&](std::size_t j) { s += jacobian[i][j] * weighted[k][j]; });
        covariance[i][k] = s;
      }
    Misfits scale;
    for (std::size_t i = 0; i < n; ++i) scale[i] = 1 / std::sqrt(covariance[i][i]);
    Square l;  // Cholesky factor of the correlations, with 1 / its diagonal
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k <= i; ++k) {
        double s = scale[i] * covariance[i][k] * scale[k];
        for (std::size_t j = 0; j < k; ++j) s -= l[i][j] * l[k][j];
        l[i][k] = i == k ? 1 / std::sqrt(s) : s * l[k][k];
      }
    const auto column = [&](int j, double size) {
      Misfits c;
      for (std::size_t i = 0; i < n; ++i) c[i] = jacobian[i][at_(j)] * size;
      return decorrelated(l, scale, c);
    };
    Misfits t = decorrelated(l, scale, w), own = column(in_error_, 1);
    Step s;
    double bz = 0;
    if (without_bz_) {
      const double sd_z = std::sqrt(variance_[kAxialMagnetometer]);
      const Misfits z = column(kAxialMagnetometer, sd_z);
      const double squared = dot(z, z);
      s.bz_is_lost = !(squared > 1e-10);  // kLeastRedundancy
      if (!s.bz_is_lost) {
        bz = dot(z, t) / squared * sd_z;
        const double of_own = dot(z, own) / squared;
        for (std::size_t i = 0; i < n; ++i) {
          t[i] -= z[i] * (bz / sd_z);
          own[i] -= z[i] * of_own;
        }
      }
    }
    Misfits back = t;  // scale L'^-1 t
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = i + 1; k < n; ++k) back[i] -= l[k][i] * back[k];
      back[i] *= l[i][i];
    }
    s.next = y;
    for (std::size_t i = 0; i < n; ++i)
      of_condition(static_cast<int>(i), [&](std::size_t j) { s.next[j] -= weighted[i][j] * (scale[i] * back[i]); });
    if (without_bz_) s.next[kAxialMagnetometer] = y[kAxialMagnetometer] - bz;
    const double size = std::sqrt(dot(own, own));
    // r of 1e-10, kLeastRedundancy
    s.shift = {std::sqrt(dot(t, t)), size * sd() > 1e-5 ? std::abs(dot(own, t)) / size : 0};
    return s;
  }

  /// An Omega that is smaller than shift^2 by more than rounding.
  static double omega_below(double shift) { return shift * shift - 1e-9 * (1 + shift * shift); }

  Minimum minimum(const Values& y) const {
    StationReadings readings;
    for (int k = 0; k < kStations; ++k) {
      readings.readings.emplace_back();
      for (int i = 0; i < 6; ++i) readings.readings.back()[at_(i)] = y[at_(6 * k + i)];
    }
    for (int j = 0; j < 3; ++j) readings.references[at_(j)] = y[at_(kReferencesAt + j)];
    AdjustmentModel m = model_;
    m.rotational_shot = false;
    std::optional<Eigen::MatrixXd> shared;
    if (covariance_.size() > 0) shared = covariance_;
    return minimum_of_omega(m, readings, Eigen::Map<const Eigen::VectorXd>(variance_.data(), kCount), {}, shared);
  }

  /// Conditions at the observations `y`, and their derivatives. Corrected reading = reading - bias - scale reading.
  void linearise(const Values& y, Misfits& values, Jacobian& jacobian) const {
    for (int k = 0; k < kStations; ++k) {
      const Conditions c = station_conditions(corrected(y, k).data());
      for (int i = 0; i < 3; ++i) {
        Values& row = jacobian[at_(3 * k + i)];
        row.fill(0);
        values[at_(3 * k + i)] = c.values[i] - y[at_(kReferencesAt + i)];
        row[at_(kReferencesAt + i)] = -1;
        for (int j = 0; j < 6; ++j) {
          const double by_reading = c.jacobian(i, j);
          row[at_(6 * k + j)] = by_reading;
          if constexpr (!kSystematic) continue;
          row[at_(6 * k + j)] *= 1 - y[at_(kScalesAt + j)];
          row[at_(kBiasesAt + j)] = -by_reading;
          row[at_(kScalesAt + j)] = -y[at_(6 * k + j)] * by_reading;
        }
      }
    }
  }

  AdjustmentModel model_;
  Values truth_{}, variance_{}, inverse_sd_{};
  Eigen::MatrixXd covariance_;  // of the shared quantities, where it is full
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
  const auto y = shift.corrected(solution.adjusted);
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
  const Eigen::MatrixXd* full = s.shared.size() > 0 ? &s.shared : nullptr;
  if (s.shared.rows() > 3)
    return detected_in(ErrorShift<1, true>(s.model, s.at, observation, full), lambda0, sign, test);
  return detected_in(ErrorShift<1, false>(s.model, s.at, observation, full), lambda0, sign, test);
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
