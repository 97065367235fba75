#pragma once
/// First-order prediction of multi-station analysis with any parameters, and of the position after it: the counterpart
/// of msa_prediction.h.
///
/// As there, a draw moves the position directly, by its station's corrected readings, and through the estimate: both
/// are effects of one draw and are added before anything is squared (first_order.h). A tool's error that is not in the
/// set stays in the readings.
///
/// Of a robust loss as multistation/loss.h says: weights k of all stations; what is drawn at a station acts through the
/// estimate by v - 1 more of its variance, in addition to everything else. Errors that stations share act as with least
/// squares. This holds for many stations, and within the limits of robust_limits.h.
#include <Eigen/Core>

#include "analysis/multistation_trials.h"
#include "analysis/robust_limits.h"
#include "multistation/robust.h"
#include "multistation/set_observability.h"

namespace surveymc::analysis {

struct MultistationPrediction {
  Eigen::VectorXd shift;       ///< mean of estimate less truth: the pull of the priors on the nominal tool
  Eigen::MatrixXd covariance;  ///< of estimate less truth of the run, parameters of the set
  Eigen::MatrixXd claimed;     ///< what the estimator claims by its priors, sizes and errors of the reference
  Eigen::VectorXd learnt;      ///< 1 - claimed variance / prior variance
  Eigen::Vector3d position;    ///< mean error of the final position, N, E, V in m
  Eigen::Matrix3d position_covariance;
  Eigen::Matrix3d uncorrected_covariance;  ///< of readings that are taken as they are
  /// One sd of the last station's magnetic azimuth, rad, without and with the correction; not finite in a vertical
  /// hole.
  double uncorrected_azimuth_sd = 0, azimuth_sd = 0;
  multistation::SetObservability observability;
  RobustLimits limits;  ///< of a robust loss
};

/// `cost`: of the estimator's loss, that of least squares without it. Throws InputError where stations and priors do
/// not determine the parameters.
MultistationPrediction predict_multistation(const MultistationRun& run, const multistation::FitOptions& estimator,
                                            const multistation::LossCost& cost = {});

}  // namespace surveymc::analysis
