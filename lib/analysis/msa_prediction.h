#pragma once
/// First-order predictions for an estimator and the position after it, made before any trial: shared by the studies of
/// MSA.
#include <array>

#include <Eigen/Core>

#include "analysis/first_order.h"
#include "estimate/estimator.h"
#include "sensor/magnetometer.h"
#include "sensor/tool_spread.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::analysis {

struct MsaPrediction {
  Eigen::Matrix<double, 6, 1> parameters;            ///< mean of the estimate: gain x, y, z (1), bias x, y, z (nT)
  Eigen::Matrix<double, 6, 6> parameter_covariance;  ///< of the estimate less the truth of the run
  Eigen::Vector2d reference_shift;                   ///< mean error of the reference after the estimate: nT, rad
  Eigen::Matrix2d reference_covariance;              ///< its covariance
  /// Covariance of parameters and reference that the estimator claims, by the errors that it assumes.
  Eigen::Matrix<double, 8, 8> claimed_covariance;
  /// One sd of the magnetic azimuth of the hole at the first, middle and last station that follows from the claimed
  /// covariance, with the correlation of the station's own noise and the estimate, rad; not finite in a vertical hole.
  std::array<double, 3> claimed_azimuth_sd;
  Eigen::Vector3d position;     ///< mean final position, N, E, V in metres from the first station
  Eigen::Vector3d uncorrected;  ///< final position of the noise-free, uncorrected readings
  /// Covariance of the final position. joint: the whole first order, that of `linear`; systematic, random: by what the
  /// sds of the six parameters do where they are taken as independent (propagate/station_effects.h), without noise.
  std::array<Eigen::Matrix3d, 3> position_covariance;
  /// The errors of parameters and position as linear functions of a trial's draws, and their exact moments. A draw
  /// moves the position directly and through the estimate (first_order.h).
  sensor::NoiseWeights weights;
  sensor::NoiseSumMoments linear;
};

/// Number of the first, middle and last of so many stations.
std::array<std::size_t, 3> first_middle_last(std::size_t stations);

/// `clean` are the readings of this survey by this tool (`spread`: by tools that vary about it). Throws InputError when
/// the stations cannot determine the parameters. `correlation`: of the reference's draws, 2 station + {0 total field,
/// 1 dip}, where they are drawn at every station; null: they are independent.
MsaPrediction predict_msa(const survey::Survey& survey, const survey::ReferenceField& field,
                          const sensor::MagnetometerErrors& errors, const sensor::ToolSpread& spread,
                          const sensor::NoiseModel& noise, const sensor::CleanReadings& clean,
                          const estimate::EstimatorOptions& estimator, const Eigen::MatrixXd* correlation = nullptr);

/// `effects` of draws of size 1 as weights; inputs that are not drawn have none.
sensor::NoiseWeights noise_weights(const InputEffects<sensor::NoiseWeights::kSums>& effects,
                                   const sensor::NoiseModel& noise, const sensor::ToolSpread& spread);

/// One standard deviation of every input's error.
estimate::InputErrors input_errors(const sensor::NoiseModel& noise, const sensor::ToolSpread& spread,
                                   const survey::ReferenceField& field);

}  // namespace surveymc::analysis
