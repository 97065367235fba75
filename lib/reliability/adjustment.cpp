#include "reliability/adjustment.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>

#include "base/units.h"
#include "reliability/conditions.h"
#include "reliability/minimum.h"
#include "simd/dual.h"
#include "stats/linear_algebra.h"

namespace surveymc::reliability {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kSix = kReadings;

bool has_references(const AdjustmentModel& m) { return m.mode != AdjustmentMode::mse_fixed; }
bool is_rotational(const AdjustmentModel& m) { return m.mode == AdjustmentMode::mse_shared && m.rotational_shot; }
bool has_systematic(const AdjustmentModel& m) { return m.mode == AdjustmentMode::mse_shared && m.systematic_terms; }

void check_stations(const AdjustmentModel& m, std::size_t stations) {
  if (stations == 0 || (stations > 1 && m.mode != AdjustmentMode::mse_shared))
    throw std::invalid_argument("one station, or mse_shared");
}

Index references_at(std::size_t stations) { return kSix * static_cast<Index>(stations); }
Index count_of(const AdjustmentModel& m, std::size_t stations) {
  return references_at(stations) + (has_references(m) ? 3 : 0) + (has_systematic(m) ? 12 : 0);
}

/// Direction of the hole that one shot's readings give (magnetic N frame), and its derivatives by them.
struct Direction {
  Eigen::Vector3d values;
  StationJacobian jacobian;
};
Direction direction_of(const std::array<double, kReadings>& readings) {
  using D = simd::Dual<double, kReadings>;
  std::array<D, kReadings> y;
  for (std::size_t i = 0; i < kReadings; ++i) y[i] = D::variable(readings[i], i);
  const survey::Vec3<D> g{y[0], y[1], y[2]};
  const survey::Vec3<D> t = survey::tangent_from_fields(scale(D(1.0) / norm(g), g), {y[3], y[4], y[5]});
  Direction d;
  for (const auto& [row, x] : {std::pair{0, &t.x}, std::pair{1, &t.y}, std::pair{2, &t.z}}) {
    d.values[row] = x->a;
    for (std::size_t i = 0; i < kReadings; ++i) d.jacobian(row, static_cast<Index>(i)) = x->d[i];
  }
  return d;
}

/// All conditions at the observations `y`, and their derivatives.
struct LinearisedConditions {
  VectorXd values;
  MatrixXd jacobian;
};
LinearisedConditions linearise_conditions(const AdjustmentModel& m, std::size_t stations,
                                          const std::array<double, 3>& fixed, const VectorXd& y) {
  const Index refs = references_at(stations), terms = refs + 3;
  const auto count = static_cast<Index>(stations);
  const Index rows = 3 * count + (is_rotational(m) ? 2 * (count - 1) : 0);
  LinearisedConditions l{VectorXd(rows), MatrixXd::Zero(rows, y.size())};
  Direction first;
  // Two directions at right angles to the hole: no angle that could be singular.
  Eigen::Matrix<double, 2, 3> across = Eigen::Matrix<double, 2, 3>::Zero();
  for (Index k = 0; k < static_cast<Index>(stations); ++k) {
    std::array<double, kReadings> corrected;
    for (Index i = 0; i < kSix; ++i) {
      const double reading = y[kSix * k + i];
      corrected[static_cast<std::size_t>(i)] =
          has_systematic(m) ? reading - y[terms + i] - y[terms + kSix + i] * reading : reading;
    }
    const Conditions c = station_conditions(corrected.data());
    for (Index j = 0; j < 3; ++j)
      l.values[3 * k + j] = c.values[j] - (has_references(m) ? y[refs + j] : fixed[static_cast<std::size_t>(j)]);
    l.jacobian.block<3, kSix>(3 * k, kSix * k) = c.jacobian;
    if (is_rotational(m)) {
      const Direction t = direction_of(corrected);
      if (k == 0) {
        first = t;
        const Eigen::Vector3d any = t.values.unitOrthogonal();
        across << any.transpose(), t.values.normalized().cross(any).transpose();
      } else {
        const Index row = 3 * count + 2 * (k - 1);
        l.values.segment<2>(row) = across * (t.values - first.values);
        l.jacobian.block<2, kSix>(row, kSix * k) = across * t.jacobian;
        l.jacobian.block<2, kSix>(row, 0) = -across * first.jacobian;
      }
    }
    if (has_references(m)) l.jacobian.block<3, 3>(3 * k, refs) = -Eigen::Matrix3d::Identity();
    if (!has_systematic(m)) continue;
    // Chain rule through corrected = reading - bias - scale reading; columns so far are by the corrected readings
    for (Index i = 0; i < kSix; ++i) {
      l.jacobian.block<3, 1>(3 * k, terms + i) = -c.jacobian.col(i);
      l.jacobian.block<3, 1>(3 * k, terms + kSix + i) = -y[kSix * k + i] * c.jacobian.col(i);
    }
  }
  if (has_systematic(m))
    for (Index k = 0; k < count; ++k)
      for (Index i = 0; i < kSix; ++i) {
        const VectorXd column = l.jacobian.col(kSix * k + i);
        if (rows > 3 * count) {
          l.jacobian.col(terms + i).tail(rows - 3 * count) -= column.tail(rows - 3 * count);
          l.jacobian.col(terms + kSix + i).tail(rows - 3 * count) -= y[kSix * k + i] * column.tail(rows - 3 * count);
        }
        l.jacobian.col(kSix * k + i) = column * (1 - y[terms + kSix + i]);
      }
  return l;
}

/// Misclosures at the readings, of conditions that are linear around `y` less `difference`.
VectorXd misclosures(const LinearisedConditions& l, const VectorXd& difference) {
  return l.values + l.jacobian * difference;
}

}  // namespace

VectorXd adjustment_variances(const AdjustmentModel& model,
                              const std::vector<std::array<double, kReadings>>& readings) {
  check_stations(model, readings.size());
  VectorXd v(count_of(model, readings.size()));
  for (std::size_t k = 0; k < readings.size(); ++k) {
    Observations y{};
    std::copy(readings[k].begin(), readings[k].end(), y.begin());
    const Observations of_station = observation_variances(model, y);
    for (std::size_t i = 0; i < kReadings; ++i) v[static_cast<Index>(kReadings * k + i)] = of_station[i];
    const Index refs = references_at(readings.size());
    if (has_references(model))
      for (std::size_t j = 0; j < 3; ++j) v[refs + static_cast<Index>(j)] = of_station[kReadings + j];
    if (!has_systematic(model)) continue;
    for (std::size_t i = 0; i < kReadings; ++i) {
      v[refs + 3 + static_cast<Index>(i)] = variance_parts(model.sigma, i, 0).systematic;
      const double scale = i < 3 ? model.sigma.accelerometer_scale : model.sigma.magnetometer_scale;
      v[refs + 9 + static_cast<Index>(i)] = scale * scale;
    }
  }
  return v;
}

Index observation_number(const AdjustmentModel& model, std::size_t stations, std::size_t station,
                         std::size_t observation) {
  check_stations(model, stations);
  if (!is_observed(model.mode, observation) || station >= stations)
    throw std::invalid_argument(observation_names()[observation] + " of that station is not observed");
  if (observation >= kReadings) return references_at(stations) + static_cast<Index>(observation - kReadings);
  return static_cast<Index>(kReadings * station + observation);
}

StationAdjustment adjust(const AdjustmentModel& model, const StationReadings& in, const VectorXd& variances,
                         const std::vector<Index>& left_out) {
  constexpr int kMost = 30;  // Gauss-Newton steps; where residuals change the curvature much they never converge
  constexpr double kTolerance = 1e-9;  // converged: no adjusted observation moves by more of its sd in a step
  const std::size_t stations = in.readings.size();
  check_stations(model, stations);
  const Index n = count_of(model, stations), refs = references_at(stations);
  if (variances.size() != n) throw std::invalid_argument("variances do not go with the observations");
  VectorXd y = VectorXd::Zero(n);
  for (std::size_t k = 0; k < stations; ++k)
    for (std::size_t i = 0; i < kReadings; ++i) y[static_cast<Index>(kReadings * k + i)] = in.readings[k][i];
  if (has_references(model))
    for (std::size_t j = 0; j < 3; ++j) y[refs + static_cast<Index>(j)] = in.references[j];
  std::vector<Index> out = left_out;
  if (model.mode == AdjustmentMode::sse_axial) out.push_back(static_cast<Index>(index_of(Observation::bz)));

  StationAdjustment a;
  VectorXd adjusted = y;
  for (a.iterations = 1; a.iterations <= kMost; ++a.iterations) {
    const LinearisedConditions l = linearise_conditions(model, stations, in.references, adjusted);
    const VectorXd w = misclosures(l, y - adjusted);
    const MatrixXd weighted = variances.asDiagonal() * l.jacobian.transpose();
    const MatrixXd covariance = l.jacobian * weighted;
    const VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
    const stats::Cholesky factor = stats::cholesky(scale.asDiagonal() * covariance * scale.asDiagonal());
    VectorXd t = factor.solve_lower(scale.cwiseProduct(w));
    VectorXd error = VectorXd::Zero(n);  // of the observations that are left out
    if (!out.empty()) {
      MatrixXd z(l.jacobian.rows(), static_cast<Index>(out.size()));
      for (std::size_t k = 0; k < out.size(); ++k)
        z.col(static_cast<Index>(k)) = l.jacobian.col(out[k]) * std::sqrt(variances[out[k]]);
      z = factor.solve_lower(scale.asDiagonal() * z);
      constexpr double kLeastPivot = 1e-5;  // as for redundancy numbers: 1e-10 in the square
      const VectorXd size = stats::least_squares_solution(z, t, kLeastPivot);
      t -= z * size;
      for (std::size_t k = 0; k < out.size(); ++k)
        error[out[k]] = size[static_cast<Index>(k)] * std::sqrt(variances[out[k]]);
    }
    const VectorXd residuals = weighted * (scale.asDiagonal() * factor.solve_upper(t));
    VectorXd next = y - residuals - error;
    for (const Index k : out) next[k] = y[k] - error[k];
    a.residuals = y - next;
    a.omega = t.squaredNorm();
    double step = 0;
    for (Index i = 0; i < n; ++i)
      if (variances[i] > 0) step = std::max(step, std::abs(next[i] - adjusted[i]) / std::sqrt(variances[i]));
    adjusted = next;
    if (!(step < kInfinity)) break;
    if (step <= kTolerance) {
      a.converged = true;
      break;
    }
  }
  if (!a.converged) {
    const Minimum m = minimum_of_omega(model, in, variances, out);
    a.iterations += m.steps;
    a.converged = m.converged;
    if (m.adjusted.allFinite()) {
      adjusted = m.adjusted;
      a.residuals = y - adjusted;
      a.omega = m.omega;
    }
  }

  const LinearisedConditions l = linearise_conditions(model, stations, in.references, adjusted);
  a.parity = without(parity_model(l.jacobian, misclosures(l, y - adjusted), variances), out);
  for (std::size_t k = 0; k < stations; ++k) {
    const double* r = adjusted.data() + kReadings * k;
    std::array<double, kReadings> corrected;
    for (std::size_t i = 0; i < kReadings; ++i) {
      const Index term = refs + 3 + static_cast<Index>(i);
      corrected[i] = has_systematic(model) ? r[i] - adjusted[term] - adjusted[term + kSix] * r[i] : r[i];
    }
    a.attitudes.push_back(survey::attitude_from_fields({corrected[0], corrected[1], corrected[2]},
                                                       {corrected[3], corrected[4], corrected[5]}));
  }
  for (std::size_t j = 0; j < 3; ++j)
    a.references[j] = has_references(model) ? adjusted[refs + static_cast<Index>(j)] : in.references[j];
  return a;
}

ParityModel linear_model(const AdjustmentModel& model, const std::vector<survey::Attitude>& attitudes) {
  check_stations(model, attitudes.size());
  std::vector<std::array<double, kReadings>> readings(attitudes.size());
  VectorXd y = VectorXd::Zero(count_of(model, attitudes.size()));
  const std::array<double, 3> references{model.field.gravity, model.field.total, model.field.dip};
  for (std::size_t k = 0; k < attitudes.size(); ++k) {
    const Observations of_station = true_observations(attitudes[k], model.field);
    for (std::size_t i = 0; i < kReadings; ++i)
      y[static_cast<Index>(kReadings * k + i)] = readings[k][i] = of_station[i];
  }
  if (has_references(model))
    for (std::size_t j = 0; j < 3; ++j) y[references_at(attitudes.size()) + static_cast<Index>(j)] = references[j];
  const LinearisedConditions l = linearise_conditions(model, attitudes.size(), references, y);
  const ParityModel all =
      parity_model(l.jacobian, VectorXd::Zero(l.values.size()), adjustment_variances(model, readings));
  if (model.mode != AdjustmentMode::sse_axial) return all;
  return without(all, {static_cast<Index>(index_of(Observation::bz))});
}

}  // namespace surveymc::reliability
