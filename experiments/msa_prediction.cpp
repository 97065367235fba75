#include "msa_prediction.h"

#include <cmath>

#include "estimate/msa_sensitivity.h"
#include "propagate/position_covariance.h"
#include "survey/minimum_curvature.h"

namespace surveymc {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

using ErrorByInput = Eigen::Matrix<double, NoiseWeights::kSums, Eigen::Dynamic>;

/// Errors of parameters and of the position by one input: the latter through the estimate, and directly.
template <class ByInput, class Direct>
ErrorByInput stacked(const ByInput& parameters, const Matrix36d& by_parameters, const Direct& direct) {
  ErrorByInput m(static_cast<int>(NoiseWeights::kSums), parameters.cols());
  m << parameters, by_parameters * parameters + direct;
  return m;
}

void append_rows(std::vector<double>& weights, const ErrorByInput& by_draw) {
  for (Eigen::Index c = 0; c < by_draw.cols(); ++c)
    for (Eigen::Index q = 0; q < by_draw.rows(); ++q) weights.push_back(by_draw(q, c));
}

}  // namespace

MsaPrediction predict_msa(const Survey& survey, const ReferenceField& field, const MagnetometerErrors& errors,
                          const NoiseModel& noise, const CleanReadings& clean) {
  const auto n = static_cast<std::size_t>(survey.size());
  std::vector<StationFields> fields;
  std::vector<Vec3<double>> uncorrected;
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3<double> u = scale(1 / norm(clean.gravity_T[k]), clean.gravity_T[k]);
    fields.push_back({clean.field_T[k], u});
    uncorrected.push_back(magnetic_to_true(tangent_from_fields(u, clean.magnetic_T[k]), std::sin(field.declination),
                                           std::cos(field.declination)));
  }
  MsaPrediction p;
  for (int i = 0; i < 3; ++i) {
    const auto a = static_cast<std::size_t>(i);
    p.parameters[i] = errors.gain[a];
    // A noise law with a mean other than zero is one more bias, and MSA finds it.
    p.parameters[3 + i] = errors.bias[a] + noise.magnetometer * unit_noise_mean(noise.law);
  }
  p.position = minimum_curvature_positions(survey).back();
  p.uncorrected = minimum_curvature_positions(survey.md(), uncorrected).back();

  const double magnetometer_sd = noise.magnetometer * std::sqrt(unit_noise_variance(noise.law));
  const double down_sd = noise.accelerometer / field.gravity;
  const bool per_station = noise.reference == ReferenceNoise::per_station;
  const MsaSensitivity sensitivity = msa_sensitivity(fields, errors.gain, field.total, field.dip);
  p.parameter_covariance = msa_covariance(
      sensitivity, fields, {magnetometer_sd, down_sd, noise.reference_total, noise.reference_dip, per_station});

  const std::vector<StationEffect> effects = final_position_effects(survey.md(), fields, field.declination);
  std::vector<Matrix36d> by_error;
  Matrix36d by_constant_error = Matrix36d::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    by_error.push_back(magnetometer_error_effect(effects[k], fields[k], errors.gain));
    by_constant_error += by_error.back();
  }
  const Vector6d sd = p.parameter_covariance.diagonal().cwiseSqrt();
  p.position_covariance = {propagate_joint(by_error, p.parameter_covariance) +
                               propagate_station_noise(effects, fields, errors.gain, magnetometer_sd, down_sd),
                           propagate_systematic(by_error, sd), propagate_random(by_error, sd)};

  const Vector3d per_gain(1 / errors.gain[0], 1 / errors.gain[1], 1 / errors.gain[2]);
  const Eigen::Vector2d reference_sd(noise.reference_total, noise.reference_dip);
  Matrix62d reference = Matrix62d::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    append_rows(p.weights.magnetometer,
                noise.magnetometer * stacked(sensitivity.by_magnetometer[k], by_constant_error,
                                             Matrix3d(effects[k].by_field * per_gain.asDiagonal())));
    if (noise.accelerometer > 0) {
      const Vector3d u = to_eigen(fields[k].down_T);
      const Matrix3d across = down_sd * (Matrix3d::Identity() - u * u.transpose());
      append_rows(p.weights.accelerometer, stacked(Matrix63d(sensitivity.by_down[k] * across), by_constant_error,
                                                   Matrix3d(effects[k].by_down * across)));
    }
    reference = sensitivity.by_reference[k] * reference_sd.asDiagonal() +
                (per_station ? Matrix62d(Matrix62d::Zero()) : reference);
    if (noise.reference != ReferenceNoise::none && (per_station || k + 1 == n))
      append_rows(p.weights.reference, stacked(reference, by_constant_error, Eigen::Matrix<double, 3, 2>::Zero()));
  }
  p.linear = noise_sum_moments(p.weights, noise.law);

  // A direction that azimuth errors do not reach to first order (the vertical of a plane well) has variance zero; what
  // arithmetic leaves there is 1e-30 of the rest, and zero is what the tables should say.
  for (Matrix3d& c : p.position_covariance)
    for (int i = 0; i < 3; ++i)
      if (c(i, i) < 1e-24 * c.trace()) {
        c.row(i).setZero();
        c.col(i).setZero();
      }
  return p;
}

}  // namespace surveymc
