#pragma once
/// First-order effect of every input of an estimator on its error. From it follow the analytic prediction with which
/// Monte Carlo is compared, and the covariance that an estimator claims.
#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "estimate/estimator.h"

namespace surveymc::estimate {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Matrix63d = Eigen::Matrix<double, 6, 3>;
using Matrix62d = Eigen::Matrix<double, 6, 2>;
using Matrix83d = Eigen::Matrix<double, 8, 3>;
using Matrix82d = Eigen::Matrix<double, 8, 2>;
using Matrix86d = Eigen::Matrix<double, 8, 6>;

/// Derivatives of the error (estimate less truth) at noise-free readings, one matrix per station. Rows: gain x, y, z;
/// bias x, y, z in nT; then the reference after the estimate (estimated by msa_joint, else as given): total field in
/// nT, dip in rad.
/// Exact to first order where the residuals vanish at the truth, that is without priors of gains and biases. With J the
/// Jacobian of (Bh, Bv), W their weight and P the priors,  d estimate = -(J'WJ + P)^-1 J'W d(Bh - Bh_ref, Bv - Bv_ref).
struct Sensitivity {
  std::vector<Matrix83d> by_magnetometer;  ///< per nT of a magnetometer reading (tool axes)
  std::vector<Matrix83d> by_down;          ///< per unit of the down direction (any direction; project it yourself)
  std::vector<Matrix82d> by_reference;     ///< per nT of total field, per rad of dip, given to the estimator
  /// Per unit of a true parameter away from its nominal: the pull of the priors; for a parameter that is not estimated,
  /// its own error (-1) and its effect on the estimates.
  Matrix86d by_truth = Matrix86d::Zero();
  Vector8d shift = Vector8d::Zero();  ///< error at the nominal parameters without noise, by the same two effects
  /// Condition of the unknown parameters' normal matrix, gains in 1, biases in total fields: its largest eigenvalue (at
  /// least that of a bias that all stations see fully) over the smallest.
  double condition = 1;
  /// Condition of the normal matrix of all unknowns, priors and an estimated reference included, scaled to a unit
  /// diagonal: independent of units and sizes. Infinite where an unknown moves no residual and has no prior.
  double scaled_condition = 1;
};

/// Nominal truth at which an estimator is linearised.
struct NominalTruth {
  std::vector<survey::StationFields> stations;
  std::array<double, 3> gain{1, 1, 1}, bias{0, 0, 0};  ///< 1, nT
  survey::ReferenceField field;                        ///< total (nT) and dip (rad) are used
};

/// Throws InputError where the estimator has no prediction of its own (estimators.h), and when the stations (and
/// priors) cannot determine the unknown parameters: normal matrix numerically singular. Options as for make_estimator.
/// A parameter that is not estimated enters to first order in the difference of its nominal truth from 1 or 0.
Sensitivity sensitivity(const EstimatorOptions& options, const NominalTruth& truth);

/// As sensitivity(), but without value where sensitivity() throws because the stations determine too little.
std::optional<Sensitivity> find_sensitivity(const EstimatorOptions& options, const NominalTruth& truth);

/// Predictions for the table of estimators (estimators.h): one for all estimators that fit (Bh, Bv), and one for wls.
/// Where the stations determine too little, the result has the condition but no derivatives.
Sensitivity field_fit_sensitivity(const EstimatorOptions& options, const NominalTruth& truth);
Sensitivity wls_sensitivity(const EstimatorOptions& options, const NominalTruth& truth);

/// Covariance of the error, rows as in Sensitivity: the sum of the contributions of all inputs. Magnetometer noise,
/// tilts of the down direction and disturbances of the field are independent per station; the reference is drawn once
/// (a consider parameter) or per station. With the errors that the estimator assumes, this is the covariance that the
/// estimator claims. `correlation`: of the reference's draws, 2 station + {0 total field, 1 dip}, where they are drawn
/// at every station; null: they are independent.
Matrix8d error_covariance(const Sensitivity& sensitivity, const std::vector<survey::StationFields>& stations,
                          const InputErrors& errors, const Eigen::MatrixXd* correlation = nullptr);

}  // namespace surveymc::estimate
