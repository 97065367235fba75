#pragma once
/// The readable counterpart of lib/reliability: least squares with the paper's design matrix (eqs 1, 21, 39-44),
/// written down as it stands and differentiated by complex steps. Singular in a vertical hole, slow, and easy to
/// believe.
#include <vector>

#include <Eigen/Core>

#include "reliability/observations.h"

namespace surveymc::test {

struct LeastSquares {
  Eigen::MatrixXd design;      ///< X, observations x unknowns (I, tau, A of each station; then G, B, Theta; then xi)
  Eigen::VectorXd variance;    ///< of the observations: six of each station, then references, then priors of xi
  Eigen::MatrixXd redundancy;  ///< R, eq 21
  Eigen::MatrixXd effect;      ///< (X'PX)^-1 X'P: unknowns x observations
  std::vector<bool> observed;
};

LeastSquares least_squares(const reliability::AdjustmentModel& model, const std::vector<survey::Attitude>& attitudes);

}  // namespace surveymc::test
