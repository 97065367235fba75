#include "propagate/sensor_error_covariance.h"

#include <array>
#include <cmath>

#include "base/units.h"
#include "propagate/station_effects.h"

namespace surveymc::propagate {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3x12d tangent_by_sensor_terms(const survey::Vec3<double>& gravity_T, const survey::Vec3<double>& field_T) {
  const double gravity = norm(gravity_T);
  const survey::Vec3<double> down = scale(1 / gravity, gravity_T);
  const TangentDerivatives d = tangent_derivatives({field_T, down});
  const Vector3d u = survey::to_eigen(down);
  const Matrix3d by_gravity = d.by_down * (Matrix3d::Identity() - u * u.transpose()) / gravity;
  Matrix3x12d w;
  w.middleCols<3>(survey::kAccelerometerBias) = by_gravity;
  w.middleCols<3>(survey::kAccelerometerScale) = by_gravity * survey::to_eigen(gravity_T).asDiagonal();
  w.middleCols<3>(survey::kMagnetometerBias) = d.by_field;
  w.middleCols<3>(survey::kMagnetometerScale) = d.by_field * survey::to_eigen(field_T).asDiagonal();
  return w;
}

namespace {

/// Tangent changes by unit-variance errors at one toolface, true north.
Matrix3x12d weights_at(const survey::Station& station, double toolface, const survey::ReferenceField& field,
                       const survey::SensorTermArray& sd) {
  survey::Attitude at = survey::magnetic_attitude(station, field.declination);
  at.toolface = toolface;
  const Eigen::Map<const Eigen::Matrix<double, survey::kSensorTerms, 1>> size(sd.data());
  return survey::true_from_magnetic(field.declination) *
         tangent_by_sensor_terms(scale(field.gravity, survey::down_T(at)),
                                 survey::magnetic_T(at, field.total, field.dip)) *
         size.asDiagonal();
}

/// The weights as a trigonometric polynomial of toolface: mean + sum_h (cosine_h cos h tau + sine_h sin h tau), h =
/// 1, 2. `waves` holds cosine_1, sine_1, cosine_2, sine_2, each divided by sqrt 2: over the circle their squares add up
/// to the variance of the weights.
struct Harmonics {
  Matrix3x12d mean = Matrix3x12d::Zero();
  Eigen::Matrix<double, 3, 4 * survey::kSensorTerms> waves = Eigen::Matrix<double, 3, 4 * survey::kSensorTerms>::Zero();
};

Harmonics harmonics(const survey::Station& station, const survey::ReferenceField& field,
                    const survey::SensorTermArray& sd) {
  // Five toolfaces determine a polynomial of the second order: the sums below are exact.
  constexpr int kPoints = 5;
  Harmonics h;
  for (int m = 0; m < kPoints; ++m) {
    const double tau = 2 * kPi * m / kPoints;
    const Matrix3x12d w = weights_at(station, tau, field, sd) / kPoints;
    h.mean += w;
    for (int order = 1; order <= 2; ++order) {
      h.waves.middleCols<survey::kSensorTerms>((2 * order - 2) * survey::kSensorTerms) +=
          std::sqrt(2.0) * std::cos(order * tau) * w;
      h.waves.middleCols<survey::kSensorTerms>((2 * order - 1) * survey::kSensorTerms) +=
          std::sqrt(2.0) * std::sin(order * tau) * w;
    }
  }
  return h;
}

}  // namespace

std::vector<TangentErrors> sensor_tangent_errors(const survey::Survey& survey, const survey::ReferenceField& field,
                                                 const survey::SensorTermArray& sd, const survey::ToolfacePlan& plan) {
  // Constant columns: the errors themselves, then the waves of the slide's toolface, if there is a slide.
  const Eigen::Index constants =
      plan.has(survey::ToolfaceSource::slide) ? 5 * survey::kSensorTerms : survey::kSensorTerms;
  std::vector<TangentErrors> errors;
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const survey::Station& station = survey.stations[k];
    TangentErrors e{Eigen::Matrix3Xd::Zero(3, constants), Eigen::Matrix3Xd(3, 0)};
    if (plan.source[k] == survey::ToolfaceSource::given) {
      e.constant.leftCols<survey::kSensorTerms>() = weights_at(station, plan.given[k], field, sd);
    } else {
      const Harmonics h = harmonics(station, field, sd);
      e.constant.leftCols<survey::kSensorTerms>() = h.mean;
      if (plan.source[k] == survey::ToolfaceSource::slide)
        e.constant.rightCols<4 * survey::kSensorTerms>() = h.waves;
      else
        e.independent = h.waves;
    }
    errors.push_back(std::move(e));
  }
  return errors;
}

std::vector<Matrix3d> sensor_error_covariances(const survey::Survey& survey, const survey::ReferenceField& field,
                                               const survey::SensorTermArray& sd, const survey::ToolfacePlan& plan,
                                               survey::PositionMethod method) {
  return propagate_tangent_errors(survey.md(), true_tangents(survey), sensor_tangent_errors(survey, field, sd, plan),
                                  method);
}

}  // namespace surveymc::propagate
