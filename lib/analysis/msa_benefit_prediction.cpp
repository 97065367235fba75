#include "analysis/msa_benefit_prediction.h"

#include <cmath>

#include "base/units.h"
#include "propagate/station_effects.h"
#include "sensor/magnetometer.h"

namespace surveymc::analysis {

namespace {

/// Azimuth of the last station, lateral.
using Derivatives = StationDerivatives<2>;

std::vector<Derivatives> derivatives(const survey::Survey& survey, const std::vector<survey::StationFields>& fields,
                                     double declination) {
  const survey::Station& last = survey.stations.back();
  const Eigen::RowVector3d lateral = survey::rotation_hla_from_nev(last.inclination, last.azimuth).row(1);
  std::vector<Derivatives> all;
  for (const propagate::StationEffect& e : propagate::final_position_effects(survey.md(), fields, declination)) {
    all.emplace_back();
    all.back().by_field.row(1) = lateral * e.by_field;
    all.back().by_down.row(1) = lateral * e.by_down;
  }
  // A = atan2(t.y, t.x)
  const survey::Vec3<double> t = survey::tangent_from_fields(fields.back().down_T, fields.back().field_T);
  const propagate::TangentDerivatives d = propagate::tangent_derivatives(fields.back());
  const double sine2 = t.x * t.x + t.y * t.y;
  all.back().by_field.row(0) = (t.x * d.by_field.row(1) - t.y * d.by_field.row(0)) / sine2;
  all.back().by_down.row(0) = (t.x * d.by_down.row(1) - t.y * d.by_down.row(0)) / sine2;
  return all;
}

/// Of an estimate that is always gains 1 and biases 0.
estimate::Sensitivity of_no_estimate(std::size_t stations) {
  estimate::Sensitivity s;
  s.by_magnetometer.assign(stations, estimate::Matrix83d::Zero());
  s.by_down.assign(stations, estimate::Matrix83d::Zero());
  s.by_reference.assign(stations, estimate::Matrix82d::Zero());
  s.by_truth.topRows<6>() = -estimate::Matrix6d::Identity();
  return s;
}

BenefitSd sd_of(const InputEffects<2>& effects, const Eigen::MatrixXd* correlation) {
  const Eigen::Vector2d variance = effects.covariance(correlation).diagonal();
  return {std::sqrt(variance[0]), std::sqrt(variance[1])};
}

}  // namespace

BenefitEffects benefit_effects(const survey::Survey& survey, const estimate::NominalTruth& truth,
                               const std::optional<estimate::Sensitivity>& estimated,
                               const estimate::InputErrors& errors) {
  const std::vector<Derivatives> stations = derivatives(survey, truth.stations, truth.field.declination);
  const Eigen::Matrix<double, 2, 6> y = by_estimate(stations, truth);
  BenefitEffects effects{input_effects(stations, y, of_no_estimate(stations.size()), truth, errors), {}};
  if (estimated) effects.after = input_effects(stations, y, *estimated, truth, errors);
  return effects;
}

Benefit predict_benefit(const survey::Survey& survey, const survey::ReferenceField& field,
                        const estimate::InputErrors& errors, const estimate::EstimatorOptions& estimator,
                        const Eigen::MatrixXd* correlation) {
  const estimate::NominalTruth truth{
      sensor::station_fields(sensor::clean_readings(survey, field, {})), {1, 1, 1}, {0, 0, 0}, field};
  const std::optional<estimate::Sensitivity> s = estimate::find_sensitivity(estimator, truth);
  const BenefitEffects effects = benefit_effects(survey, truth, s, errors);
  Benefit out;
  out.before = sd_of(effects.before, nullptr);  // nothing but an estimate reads the reference
  out.gain_bias_correlation = kNaN;
  if (!s) {
    out.after = {kInfinity, kInfinity};
    out.condition = kInfinity;
    return out;
  }
  out.condition = s->condition;
  out.after = sd_of(*effects.after, correlation);
  out.after_by_reference = effects.after->by_reference();
  if (estimator.estimated[2] && estimator.estimated[5]) {
    const estimate::Matrix8d c = estimate::error_covariance(*s, truth.stations, errors, correlation);
    if (c(2, 2) > 0 && c(5, 5) > 0) out.gain_bias_correlation = c(2, 5) / std::sqrt(c(2, 2) * c(5, 5));
  }
  return out;
}

double benefit_ratio(double before, double after) {
  if (before > 0) return after / before;
  return after > 0 ? kInfinity : 1;
}

}  // namespace surveymc::analysis
