#pragma once
/// All that one run of six-axis readings says: gains and biases with covariance, what the stations cannot determine,
/// the corrected survey with its covariance, and whether the residuals fit the noise. Composed of lib/; no files.
#include <optional>
#include <vector>

#include "estimate/estimator.h"
#include "estimate/observability.h"
#include "estimate/residual_tests.h"
#include "estimate/sensitivity.h"
#include "sensor/magnetometer.h"
#include "survey/reference_field.h"
#include "survey/six_axis.h"
#include "survey/survey.h"

namespace surveymc::analysis {

/// Estimators that need nothing but readings and a reference (others know the true attitude).
const std::vector<std::string>& readings_estimators();

/// Field of one station less the reference.
struct FieldResiduals {
  double horizontal = 0, vertical = 0, total = 0;  ///< nT
  double dip = 0;                                  ///< rad
};

struct StationAnalysis {
  survey::Attitude raw, corrected;  ///< azimuth magnetic; the correction is to the magnetometers, so only it changes
  double azimuth_sd = 0;            ///< rad; NaN in a vertical hole, when the accelerometers have noise
  double gravity_residual = 0;      ///< |g| less the reference, m/s2
  FieldResiduals before, after;     ///< of the readings as they are, and corrected
  Eigen::Vector3d raw_position, position;  ///< N, E, V from the first station, true north, m
  Eigen::Matrix3d position_covariance;     ///< of `position`, m2
};

struct ReadingsAnalysis {
  estimate::Vector6d parameters;            ///< gain x, y, z (1), bias x, y, z (nT)
  estimate::Matrix6d covariance;            ///< by the a-priori noise
  estimate::Matrix6d reference_covariance;  ///< the part of it that the reference's uncertainty makes
  /// Total field (nT) and dip (rad) where the estimator estimates them, and their covariance.
  std::optional<Eigen::Vector2d> reference;
  Eigen::Matrix2d reference_estimate_covariance = Eigen::Matrix2d::Zero();
  double cost = 0;      ///< sum of squared residuals (Bh, Bv), nT2
  int evaluations = 0;  ///< of the model, by the solver
  estimate::Observability observability;
  std::vector<estimate::FieldMisfit> misfits;  ///< of the corrected stations
  estimate::ResidualTests tests;
  /// Squared Mahalanobis distance of the estimate from gains 1 and biases 0: chi-squared(6) if the tool is perfect.
  double perfect_tool_statistic = 0;
  double rotation_gap = 0;               ///< rad: the widest range of toolfaces without a station
  bool vertical_field_reversed = false;  ///< most readings have the vertical field of the other hemisphere
  std::vector<StationAnalysis> stations;
};

/// Runs the estimator on the readings. `noise.magnetometer` must be positive and its law Gaussian.
/// Throws InputError when the stations cannot determine the parameters (naming the combination), when the estimator
/// does not converge, and when field and gravity are parallel at a station.
ReadingsAnalysis analyse_readings(const survey::SixAxisReadings& readings, const survey::ReferenceField& field,
                                  const sensor::NoiseModel& noise, const estimate::EstimatorOptions& estimator);

}  // namespace surveymc::analysis
