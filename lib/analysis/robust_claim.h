#pragma once
/// Which covariance a robust estimate of a tool claims (multistation/robust.h), by the weights that it has found, and
/// what a loss costs where nothing is wrong: to first order, at readings without errors.
///
///   C = N^-1 (v k sum u J'S J + B B' + P T P) N^-1,   N = sum u J'J + P,   B = sum u J'R,   u = k min(w, 1) / m
/// J: derivatives of a station's residuals by the estimated parameters, S its covariance by what is drawn at the
/// station, R its columns by the inputs of the run that are not estimated, one sd each; P: information of the priors,
/// T: covariance of the true tools. k, v, m of the loss (multistation/loss.h).
#include <vector>

#include <Eigen/Core>

#include "analysis/corrected_survey.h"
#include "multistation/fit.h"
#include "multistation/loss.h"

namespace surveymc::analysis {

/// One standard deviation of every parameter of the table as drawn: rotations and axes are exact.
multistation::PerParameter<double> tool_sizes(const propagate::CodeDraws& draws);

class RobustClaim {
 public:
  /// `noise`: of a magnetometer reading, nT. `options`: of the fit; its reference is not estimated.
  RobustClaim(const MeasuredStations& stations, const propagate::CodeDraws& draws, double noise,
              const multistation::FitOptions& options);

  /// Of the estimate less the truth, in the order of the set. Weights: one a station. Not finite where the weights
  /// leave too few stations.
  Eigen::MatrixXd covariance(const double* weights, const multistation::LossCost& cost) const;

 private:
  Eigen::VectorXd prior_, truth_;                      ///< information; variance of the true parameters
  std::vector<Eigen::MatrixXd> normal_, noise_, run_;  ///< of every station: J'J, J'SJ, J'R
};

/// Variance of the lateral position of the last station after a fit of three biases or of six parameters with this
/// loss, without priors, over that after least squares: station errors act through the estimate alone where readings
/// have no noise of their own. NaN of other sets, with noise, or where the stations do not determine the parameters.
double lateral_variance_ratio(const MeasuredStations& stations, const propagate::CodeDraws& draws, double noise,
                              const multistation::FitOptions& options, multistation::Loss loss);

}  // namespace surveymc::analysis
