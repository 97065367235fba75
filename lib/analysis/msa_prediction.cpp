#include "analysis/msa_prediction.h"

#include <cmath>

#include "estimate/sensitivity.h"
#include "propagate/corrected_well_covariance.h"
#include "propagate/station_effects.h"
#include "survey/minimum_curvature.h"

namespace surveymc::analysis {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

using ErrorByInput = Eigen::Matrix<double, sensor::NoiseWeights::kSums, Eigen::Dynamic>;

/// Errors of parameters and of the position by one input: the position depends on it through the estimate, and
/// directly.
template <class ByInput, class Direct>
ErrorByInput stacked(const ByInput& parameters, const propagate::Matrix36d& by_parameters, const Direct& direct) {
  ErrorByInput m(static_cast<int>(sensor::NoiseWeights::kSums), parameters.cols());
  m << parameters, by_parameters * parameters + direct;
  return m;
}

void append_rows(std::vector<double>& weights, const ErrorByInput& by_draw) {
  for (Eigen::Index c = 0; c < by_draw.cols(); ++c)
    for (Eigen::Index q = 0; q < by_draw.rows(); ++q) weights.push_back(by_draw(q, c));
}

/// Claimed sd of the azimuth at station k: its own noise and the estimate move the corrected field by
///   db_i = (noise_i - b_i dgain_i - dbias_i) / gain_i.
double claimed_azimuth_sd(const estimate::Sensitivity& sensitive, const std::vector<survey::StationFields>& fields,
                          std::size_t k, const std::array<double, 3>& gain, const estimate::InputErrors& assumed,
                          const propagate::Matrix6d& claimed) {
  const propagate::AzimuthDerivatives by = propagate::azimuth_derivatives(fields[k]);
  const Vector3d u = survey::to_eigen(fields[k].down_T), b = survey::to_eigen(fields[k].field_T);
  const Eigen::RowVector3d by_reading = by.by_field.array() / Eigen::RowVector3d(gain[0], gain[1], gain[2]).array();
  const Matrix3d tilt = assumed.down * (Matrix3d::Identity() - u * u.transpose());
  Eigen::Matrix<double, 1, 6> own = Eigen::Matrix<double, 1, 6>::Zero(), by_parameters;
  own.head<3>() = assumed.magnetometer * by_reading;
  if (assumed.down > 0) own.tail<3>() = by.by_down * tilt;
  by_parameters << -by_reading.cwiseProduct(b.transpose()), -by_reading;
  propagate::Matrix6d by_draws;
  by_draws << assumed.magnetometer * sensitive.by_magnetometer[k].topRows<6>(),
      sensitive.by_down[k].topRows<6>() * tilt;
  return std::sqrt(propagate::covariance_with_estimate(own, by_parameters, by_draws, claimed)(0, 0));
}

}  // namespace

std::array<std::size_t, 3> first_middle_last(std::size_t stations) { return {0, stations / 2, stations - 1}; }

estimate::InputErrors input_errors(const sensor::NoiseModel& noise, const sensor::ToolSpread& spread,
                                   const survey::ReferenceField& field) {
  const bool drawn = noise.reference != sensor::ReferenceNoise::none;
  return {noise.magnetometer * std::sqrt(sensor::unit_noise_variance(noise.law)),
          noise.accelerometer / field.gravity,
          drawn ? noise.reference_total : 0,
          drawn ? noise.reference_dip : 0,
          noise.reference == sensor::ReferenceNoise::per_station,
          spread.gain,
          spread.bias,
          spread.axial_bias};
}

MsaPrediction predict_msa(const survey::Survey& survey, const survey::ReferenceField& field,
                          const sensor::MagnetometerErrors& errors, const sensor::ToolSpread& spread,
                          const sensor::NoiseModel& noise, const sensor::CleanReadings& clean,
                          const estimate::EstimatorOptions& estimator) {
  const auto n = static_cast<std::size_t>(survey.size());
  const std::vector<survey::StationFields> fields = sensor::station_fields(clean);
  std::vector<survey::Vec3<double>> uncorrected;
  for (std::size_t k = 0; k < n; ++k)
    uncorrected.push_back(survey::magnetic_to_true(survey::tangent_from_fields(fields[k].down_T, clean.magnetic_T[k]),
                                                   std::sin(field.declination), std::cos(field.declination)));
  const estimate::InputErrors sd = input_errors(noise, spread, field);
  const estimate::Sensitivity sensitive = estimate::sensitivity(estimator, {fields, errors.gain, errors.bias, field});
  MsaPrediction p;
  estimate::Vector8d errors_mean = sensitive.shift;
  for (const estimate::Matrix83d& m :
       sensitive.by_magnetometer)  // a noise law with a mean other than zero is one more bias
    errors_mean += noise.magnetometer * sensor::unit_noise_mean(noise.law) * m.rowwise().sum();
  const propagate::Vector6d shift = errors_mean.head<6>();
  p.reference_shift = errors_mean.tail<2>();
  for (int i = 0; i < 3; ++i) {
    const auto a = static_cast<std::size_t>(i);
    p.parameters[i] = errors.gain[a] + shift[i];
    p.parameters[3 + i] = errors.bias[a] + shift[3 + i];
  }
  p.uncorrected = survey::minimum_curvature_positions(survey.md(), uncorrected).back();
  const estimate::Matrix8d covariance = estimate::error_covariance(sensitive, fields, sd);
  p.parameter_covariance = covariance.topLeftCorner<6, 6>();
  p.reference_covariance = covariance.bottomRightCorner<2, 2>();
  p.claimed_covariance = estimate::error_covariance(sensitive, fields, estimator.assumed);
  const std::array<std::size_t, 3> places = first_middle_last(n);
  for (std::size_t i = 0; i < places.size(); ++i)
    p.claimed_azimuth_sd[i] = claimed_azimuth_sd(sensitive, fields, places[i], errors.gain, estimator.assumed,
                                                 p.claimed_covariance.topLeftCorner<6, 6>());

  const std::vector<propagate::StationEffect> effects =
      propagate::final_position_effects(survey.md(), fields, field.declination);
  const Vector3d per_gain(1 / errors.gain[0], 1 / errors.gain[1], 1 / errors.gain[2]);
  std::vector<propagate::Matrix36d> by_error;
  propagate::Matrix36d by_constant_error = propagate::Matrix36d::Zero();
  Vector3d by_noise_mean = Vector3d::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    by_error.push_back(propagate::magnetometer_error_effect(effects[k], fields[k], errors.gain));
    by_constant_error += by_error.back();
    by_noise_mean += effects[k].by_field * per_gain;
  }
  p.position = survey::minimum_curvature_positions(survey).back() + by_constant_error * shift +
               noise.magnetometer * sensor::unit_noise_mean(noise.law) * by_noise_mean;
  const propagate::Vector6d parameter_sd = p.parameter_covariance.diagonal().cwiseSqrt();
  p.position_covariance = {
      propagate::propagate_joint(by_error, p.parameter_covariance) +
          propagate::propagate_station_noise(effects, fields, errors.gain, sd.magnetometer, sd.down),
      propagate::propagate_systematic(by_error, parameter_sd), propagate::propagate_random(by_error, parameter_sd)};

  const Eigen::Vector2d reference_sd(sd.total, sd.dip);
  estimate::Matrix62d reference = estimate::Matrix62d::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    append_rows(p.weights.magnetometer,
                noise.magnetometer * stacked(estimate::Matrix63d(sensitive.by_magnetometer[k].topRows<6>()),
                                             by_constant_error, Matrix3d(effects[k].by_field * per_gain.asDiagonal())));
    if (noise.accelerometer > 0) {
      const Vector3d u = survey::to_eigen(fields[k].down_T);
      const Matrix3d across = sd.down * (Matrix3d::Identity() - u * u.transpose());
      append_rows(p.weights.accelerometer, stacked(estimate::Matrix63d(sensitive.by_down[k].topRows<6>() * across),
                                                   by_constant_error, Matrix3d(effects[k].by_down * across)));
    }
    reference = sensitive.by_reference[k].topRows<6>() * reference_sd.asDiagonal() +
                (sd.reference_per_station ? estimate::Matrix62d(estimate::Matrix62d::Zero()) : reference);
    if (noise.reference != sensor::ReferenceNoise::none && (sd.reference_per_station || k + 1 == n))
      append_rows(p.weights.reference, stacked(reference, by_constant_error, Eigen::Matrix<double, 3, 2>::Zero()));
  }
  if (spread.any()) {
    propagate::Matrix6d by_tool = sensitive.by_truth.topRows<6>();
    for (int i = 0; i < 6; ++i) by_tool.col(i) *= spread.sd(static_cast<std::size_t>(i));
    append_rows(p.weights.tool, stacked(by_tool, by_constant_error, Eigen::Matrix<double, 3, 6>::Zero()));
  }
  p.linear = sensor::noise_sum_moments(p.weights, noise.law);

  // A direction that azimuth errors do not move to first order (the vertical of a plane well) has variance zero.
  // Rounding leaves 1e-30 of the rest there, but the tables should say zero.
  for (Matrix3d& c : p.position_covariance)
    for (int i = 0; i < 3; ++i)
      if (c(i, i) < 1e-24 * c.trace()) {
        c.row(i).setZero();
        c.col(i).setZero();
      }
  return p;
}

}  // namespace surveymc::analysis
