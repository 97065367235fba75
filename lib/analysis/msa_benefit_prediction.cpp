#include "analysis/msa_benefit_prediction.h"

#include <cmath>

#include "base/units.h"
#include "estimate/sensitivity.h"
#include "propagate/station_effects.h"
#include "sensor/magnetometer.h"

namespace surveymc::analysis {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

using Matrix23d = Eigen::Matrix<double, 2, 3>;
using Matrix26d = Eigen::Matrix<double, 2, 6>;

/// Derivatives of azimuth (of the last station) and lateral by the readings of one station.
struct DirectEffect {
  Matrix23d by_field, by_down;
};

std::vector<DirectEffect> direct_effects(const survey::Survey& survey, const std::vector<survey::StationFields>& fields,
                                         double declination) {
  const survey::Station& last = survey.stations.back();
  const Eigen::RowVector3d lateral = survey::rotation_hla_from_nev(last.inclination, last.azimuth).row(1);
  std::vector<DirectEffect> direct;
  for (const propagate::StationEffect& e : propagate::final_position_effects(survey.md(), fields, declination)) {
    direct.push_back({Matrix23d::Zero(), Matrix23d::Zero()});
    direct.back().by_field.row(1) = lateral * e.by_field;
    direct.back().by_down.row(1) = lateral * e.by_down;
  }
  // A = atan2(t.y, t.x)
  const survey::Vec3<double> t = survey::tangent_from_fields(fields.back().down_T, fields.back().field_T);
  const propagate::TangentDerivatives d = propagate::tangent_derivatives(fields.back());
  const double sine2 = t.x * t.x + t.y * t.y;
  direct.back().by_field.row(0) = (t.x * d.by_field.row(1) - t.y * d.by_field.row(0)) / sine2;
  direct.back().by_down.row(0) = (t.x * d.by_down.row(1) - t.y * d.by_down.row(0)) / sine2;
  return direct;
}

/// Corrected field by the error (estimate less truth) of the six parameters, at gains 1: db = -b_i dgain_i - dbias_i.
Matrix26d by_parameter_error(const std::vector<DirectEffect>& direct,
                             const std::vector<survey::StationFields>& fields) {
  Matrix26d sum = Matrix26d::Zero();
  for (std::size_t k = 0; k < fields.size(); ++k) {
    sum.leftCols<3>() -= direct[k].by_field * survey::to_eigen(fields[k].field_T).asDiagonal();
    sum.rightCols<3>() -= direct[k].by_field;
  }
  return sum;
}

template <class Matrix>
void add(Vector2d& variance, const Matrix& by_draw) {
  variance += by_draw.cwiseAbs2().rowwise().sum();
}

BenefitSd root(const Vector2d& variance) { return {std::sqrt(variance[0]), std::sqrt(variance[1])}; }

}  // namespace

Benefit predict_benefit(const survey::Survey& survey, const survey::ReferenceField& field,
                        const estimate::InputErrors& errors, const estimate::EstimatorOptions& estimator) {
  const std::vector<survey::StationFields> fields = sensor::station_fields(sensor::clean_readings(survey, field, {}));
  const std::vector<DirectEffect> direct = direct_effects(survey, fields, field.declination);
  const Matrix26d by_error = by_parameter_error(direct, fields);
  propagate::Vector6d tool_sd;
  tool_sd.head<3>().setConstant(errors.gain);
  for (int axis = 0; axis < 3; ++axis) tool_sd[3 + axis] = errors.bias_sd(axis);
  const auto across = [&](std::size_t k) -> Matrix3d {
    const Vector3d u = survey::to_eigen(fields[k].down_T);
    return errors.down * (Matrix3d::Identity() - u * u.transpose());
  };

  Benefit out;
  Vector2d variance = Vector2d::Zero();
  add(variance, by_error * tool_sd.asDiagonal());
  for (std::size_t k = 0; k < fields.size(); ++k) {
    add(variance, errors.magnetometer * direct[k].by_field);
    add(variance, direct[k].by_down * across(k));
  }
  out.before = root(variance);

  out.gain_bias_correlation = kNaN;
  const std::optional<estimate::Sensitivity> s =
      estimate::find_sensitivity(estimator, {fields, {1, 1, 1}, {0, 0, 0}, field});
  if (!s) {
    out.after = {kInfinity, kInfinity};
    out.condition = kInfinity;
    return out;
  }
  out.condition = s->condition;
  variance.setZero();
  add(variance, by_error * s->by_truth.topRows<6>() * tool_sd.asDiagonal());
  Eigen::Matrix2d reference = Eigen::Matrix2d::Zero();  // one draw for the run
  const Vector2d reference_sd(errors.total, errors.dip);
  for (std::size_t k = 0; k < fields.size(); ++k) {
    add(variance, errors.magnetometer * (by_error * s->by_magnetometer[k].topRows<6>() + direct[k].by_field));
    add(variance, (by_error * s->by_down[k].topRows<6>() + direct[k].by_down) * across(k));
    const Eigen::Matrix2d by_reference = by_error * s->by_reference[k].topRows<6>() * reference_sd.asDiagonal();
    if (errors.reference_per_station)
      add(variance, by_reference);
    else
      reference += by_reference;
  }
  add(variance, reference);
  out.after = root(variance);
  if (estimator.estimated[2] && estimator.estimated[5]) {
    const estimate::Matrix8d c = estimate::error_covariance(*s, fields, errors);
    if (c(2, 2) > 0 && c(5, 5) > 0) out.gain_bias_correlation = c(2, 5) / std::sqrt(c(2, 2) * c(5, 5));
  }
  return out;
}

double benefit_ratio(double before, double after) {
  if (before > 0) return after / before;
  return after > 0 ? kInfinity : 1;
}

}  // namespace surveymc::analysis
