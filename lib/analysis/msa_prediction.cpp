#include "analysis/msa_prediction.h"

#include <cmath>

#include "propagate/corrected_well_covariance.h"
#include "propagate/station_effects.h"
#include "survey/minimum_curvature.h"

namespace surveymc::analysis {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Gains and biases, then the final position: the sums of NoiseWeights.
constexpr int kParameters = 6, kQuantities = sensor::NoiseWeights::kSums;

InputEffects<kQuantities> effects_of_draws(const std::vector<propagate::StationEffect>& on_position,
                                           const estimate::Sensitivity& sensitive, const estimate::NominalTruth& truth,
                                           const estimate::InputErrors& sizes) {
  std::vector<StationDerivatives<kQuantities>> stations(on_position.size());
  for (std::size_t k = 0; k < stations.size(); ++k) {
    stations[k].by_field.bottomRows<3>() = on_position[k].by_field;
    stations[k].by_down.bottomRows<3>() = on_position[k].by_down;
  }
  Eigen::Matrix<double, kQuantities, 6> y = by_estimate(stations, truth);
  y.topRows<kParameters>().setIdentity();
  return input_effects(stations, y, sensitive, truth, sizes);
}

template <class Effects>
void append_columns(const Effects& by_draws, std::vector<double>& weights) {
  weights.insert(weights.end(), by_draws.data(), by_draws.data() + by_draws.size());
}

/// Of the magnetic azimuth at the stations `places`, by the sizes that the estimator assumes.
std::array<double, 3> claimed_azimuth_sds(const std::array<std::size_t, 3>& places,
                                          const estimate::Sensitivity& sensitive, const estimate::NominalTruth& truth,
                                          const estimate::InputErrors& assumed) {
  std::array<double, 3> sd{};
  for (std::size_t i = 0; i < places.size(); ++i) {
    std::vector<StationDerivatives<1>> stations(truth.stations.size());
    const propagate::AzimuthDerivatives d = propagate::azimuth_derivatives(truth.stations[places[i]]);
    stations[places[i]] = {d.by_field, d.by_down};
    sd[i] = std::sqrt(input_effects(stations, by_estimate(stations, truth), sensitive, truth, assumed).covariance()(0));
  }
  return sd;
}

}  // namespace

sensor::NoiseWeights noise_weights(const InputEffects<kQuantities>& effects, const sensor::NoiseModel& noise,
                                   const sensor::ToolSpread& spread) {
  sensor::NoiseWeights w;
  for (const auto& m : effects.magnetometer) append_columns(m, w.magnetometer);
  if (noise.accelerometer > 0)
    for (const auto& m : effects.accelerometer) append_columns(m, w.accelerometer);
  if (noise.reference != sensor::ReferenceNoise::none)
    for (const auto& m : effects.reference) append_columns(m, w.reference);
  if (spread.any()) append_columns(effects.tool, w.tool);
  return w;
}

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
                          const estimate::EstimatorOptions& estimator, const Eigen::MatrixXd* correlation) {
  const estimate::NominalTruth truth{sensor::station_fields(clean), errors.gain, errors.bias, field};
  const std::vector<survey::StationFields>& fields = truth.stations;
  std::vector<survey::Vec3<double>> uncorrected;
  for (std::size_t k = 0; k < fields.size(); ++k)
    uncorrected.push_back(survey::magnetic_to_true(survey::tangent_from_fields(fields[k].down_T, clean.magnetic_T[k]),
                                                   std::sin(field.declination), std::cos(field.declination)));
  const estimate::InputErrors sd = input_errors(noise, spread, field);
  const estimate::Sensitivity sensitive = estimate::sensitivity(estimator, truth);
  const std::vector<propagate::StationEffect> effects =
      propagate::final_position_effects(survey.md(), fields, field.declination);

  MsaPrediction p;
  estimate::InputErrors sizes = sd;  // of a draw of size 1: the law's variance comes with noise_sum_moments
  sizes.magnetometer = noise.magnetometer;
  p.weights = noise_weights(effects_of_draws(effects, sensitive, truth, sizes), noise, spread);
  p.linear = sensor::noise_sum_moments(p.weights, noise.law, correlation);

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
  const estimate::Matrix8d covariance = estimate::error_covariance(sensitive, fields, sd, correlation);
  p.parameter_covariance = covariance.topLeftCorner<6, 6>();
  p.reference_covariance = covariance.bottomRightCorner<2, 2>();
  p.claimed_covariance = estimate::error_covariance(sensitive, fields, estimator.assumed);
  p.claimed_azimuth_sd = claimed_azimuth_sds(first_middle_last(fields.size()), sensitive, truth, estimator.assumed);

  const Vector3d per_gain(1 / errors.gain[0], 1 / errors.gain[1], 1 / errors.gain[2]);
  std::vector<propagate::Matrix36d> by_error;
  propagate::Matrix36d by_constant_error = propagate::Matrix36d::Zero();
  Vector3d by_noise_mean = Vector3d::Zero();
  for (std::size_t k = 0; k < fields.size(); ++k) {
    by_error.push_back(propagate::magnetometer_error_effect(effects[k], fields[k], errors.gain));
    by_constant_error += by_error.back();
    by_noise_mean += effects[k].by_field * per_gain;
  }
  p.position = survey::minimum_curvature_positions(survey).back() + by_constant_error * shift +
               noise.magnetometer * sensor::unit_noise_mean(noise.law) * by_noise_mean;
  const propagate::Vector6d parameter_sd = p.parameter_covariance.diagonal().cwiseSqrt();
  p.position_covariance = {p.linear.covariance.bottomRightCorner<3, 3>(),
                           propagate::propagate_systematic(by_error, parameter_sd),
                           propagate::propagate_random(by_error, parameter_sd)};

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
