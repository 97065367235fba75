#pragma once
/// What first-order theory says of an estimator and the position after it, before any trial: shared by the studies of
/// MSA.
#include <array>

#include <Eigen/Core>

#include "estimate/estimator.h"
#include "sensor/magnetometer.h"
#include "sensor/tool_spread.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::analysis {

struct MsaPrediction {
  Eigen::Matrix<double, 6, 1> parameters;            ///< mean of the estimate: gain x, y, z (1), bias x, y, z (nT)
  Eigen::Matrix<double, 6, 6> parameter_covariance;  ///< of the estimate less the truth of the run
  Eigen::Matrix2d reference_covariance;              ///< of the reference the estimator ends with: nT, rad
  /// Of parameters and reference, by the errors that the estimator assumes: what it says of itself.
  Eigen::Matrix<double, 8, 8> claimed_covariance;
  Eigen::Vector3d position;     ///< mean final position, N, E, V in metres from the first station
  Eigen::Vector3d uncorrected;  ///< final position of the noise-free, uncorrected readings
  /// Of the final position, by propagation: joint (with station noise), systematic, random.
  std::array<Eigen::Matrix3d, 3> position_covariance;
  /// The errors of parameters and position as linear functions of a trial's draws, and their exact moments. Unlike
  /// `joint`, this keeps the correlation of a station's own noise with the estimate that it also enters.
  sensor::NoiseWeights weights;
  sensor::NoiseSumMoments linear;
};

/// `clean` are the readings of this survey by this tool (`spread`: by tools that vary about it). Throws InputError when
/// the stations cannot determine the parameters.
MsaPrediction predict_msa(const survey::Survey& survey, const survey::ReferenceField& field,
                          const sensor::MagnetometerErrors& errors, const sensor::ToolSpread& spread,
                          const sensor::NoiseModel& noise, const sensor::CleanReadings& clean,
                          const estimate::EstimatorOptions& estimator);

/// One standard deviation of every input's error.
estimate::InputErrors input_errors(const sensor::NoiseModel& noise, const sensor::ToolSpread& spread,
                                   const survey::ReferenceField& field);

}  // namespace surveymc::analysis
