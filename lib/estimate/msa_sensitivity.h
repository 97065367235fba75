#pragma once
/// First-order effect of every input of MSA on its estimate: the analytic prediction that Monte Carlo is held against.
#include <array>
#include <vector>

#include <Eigen/Core>

#include "survey/frames.h"

namespace surveymc {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix63d = Eigen::Matrix<double, 6, 3>;
using Matrix62d = Eigen::Matrix<double, 6, 2>;

/// Derivatives of the estimate (gain x, y, z; bias x, y, z in nT) at noise-free readings, one matrix per station.
/// Exact to first order, because the residuals vanish there. With J the Jacobian of (Bh, Bv) by the parameters,
///   d estimate = -(J'J)^-1 J' d(Bh - Bh_ref, Bv - Bv_ref).
struct MsaSensitivity {
  std::vector<Matrix63d> by_magnetometer;  ///< per nT of a magnetometer reading (tool axes)
  std::vector<Matrix63d> by_down;          ///< per unit of the down direction (any direction; project it yourself)
  std::vector<Matrix62d> by_reference;     ///< per nT of total field, per rad of dip
};

/// `gain` are the true gains, `total` (nT) and `dip` (rad) the reference. Throws InputError when the stations cannot
/// determine the six parameters (J'J numerically singular).
MsaSensitivity msa_sensitivity(const std::vector<StationFields>& stations, const std::array<double, 3>& gain,
                               double total, double dip);

/// Independent noise on the inputs: magnetometer_sd (nT per axis and station), down_sd (rad per cross-axis direction:
/// accelerometer noise / gravity), reference sd (nT, rad) drawn once a run as a consider parameter, or per station.
struct MsaInputNoise {
  double magnetometer_sd = 0, down_sd = 0, total_sd = 0, dip_sd = 0;
  bool reference_per_station = false;
};

/// Covariance of the estimate: the sum of what every input contributes.
Matrix6d msa_covariance(const MsaSensitivity& sensitivity, const std::vector<StationFields>& stations,
                        const MsaInputNoise& noise);

}  // namespace surveymc
