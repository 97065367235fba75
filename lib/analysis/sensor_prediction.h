#pragma once
/// What first-order theory says of positions under constant sensor errors, before any trial.
#include <array>
#include <vector>

#include <Eigen/Core>

#include "survey/reference_field.h"
#include "survey/sensor_terms.h"
#include "survey/toolface_plan.h"

namespace surveymc::analysis {

/// Names of the predictions, in the order of PositionPredictions.
inline constexpr std::array<const char*, 3> kSensorFormulations{"toolface_dependent", "ti_systematic", "ti_random"};

/// A predicted covariance with all that a tally needs of it.
struct PositionPrediction {
  explicit PositionPrediction(const Eigen::Matrix3d& position_covariance);

  Eigen::Matrix3d covariance;         ///< N, E, V, m2
  Eigen::Vector3d sd;                 ///< m along the axes, largest first; 0 where zero to first order
  Eigen::Matrix3d axes;               ///< columns: unit vectors (N, E, V)
  Eigen::Matrix2d horizontal_axes;    ///< columns: major and minor axis of the horizontal ellipse
  Eigen::Matrix2d horizontal_weight;  ///< inverse of the horizontal part; NaN if it is a line
};

/// By formulation, in the order of kSensorFormulations.
using PositionPredictions = std::vector<PositionPrediction>;

/// At each of the `reported` stations. `first_is_tie_on`: the first station's direction has no error, as in
/// position_covariance; else it is measured.
std::vector<PositionPredictions> predict_sensor_runs(const survey::Survey& survey, const survey::ReferenceField& field,
                                                     const survey::SensorTermArray& sd,
                                                     const survey::ToolfacePlan& plan, const std::vector<int>& reported,
                                                     bool first_is_tie_on);

}  // namespace surveymc::analysis
