#pragma once
/// Analysis of one run of six-axis readings: gains and biases with covariance, the combinations that the stations
/// cannot determine, the corrected survey with its covariance, and whether the residuals fit the noise. Reads and
/// writes no files.
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
  survey::Attitude raw, corrected;         ///< azimuth magnetic: all that changes, as only magnetometers are corrected
  double azimuth_sd = 0;                   ///< rad; NaN in a vertical hole, when the accelerometers have noise
  double gravity_residual = 0;             ///< |g| less the reference, m/s2
  FieldResiduals before, after;            ///< of the uncorrected and of the corrected readings
  Eigen::Vector3d raw_position, position;  ///< N, E, V from the first station, true north, m
  Eigen::Matrix3d position_covariance;     ///< of `position`, m2
};

struct ReadingsAnalysis {
  estimate::Vector6d parameters;  ///< gain x, y, z (1), bias x, y, z (nT)
  /// Of the error of the estimate, by the a-priori noise and, with priors, by tools that vary as the priors say.
  estimate::Matrix6d covariance;
  estimate::Matrix6d perfect_covariance;    ///< of the estimate of a perfect tool: by noise and reference alone
  estimate::Matrix6d reference_covariance;  ///< the part of `covariance` that comes from the reference's uncertainty
  /// Total field (nT) and dip (rad) where the estimator estimates them, and their covariance.
  std::optional<Eigen::Vector2d> reference;
  Eigen::Matrix2d reference_estimate_covariance = Eigen::Matrix2d::Zero();
  /// Sum of the squared residuals (Bh, Bv) of the solution, nT2: less the estimated reference, if there is one. Not
  /// what a weighted estimator makes least.
  double squares = 0;
  int evaluations = 0;  ///< of the model, by the solver
  estimate::Observability observability;
  std::vector<estimate::FieldMisfit> misfits;  ///< of the corrected stations
  estimate::ResidualTests tests;
  /// Squared Mahalanobis distance of the estimate from gains 1 and biases 0: chi-squared(6) if the tool is perfect.
  double perfect_tool_statistic = 0;

  /// The parts of `covariance` that the sensors' noise and that the priors make; the third is reference_covariance.
  estimate::Matrix6d noise_covariance() const { return perfect_covariance - reference_covariance; }
  estimate::Matrix6d prior_covariance() const { return covariance - perfect_covariance; }
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
