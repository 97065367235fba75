#pragma once
/// Least-squares adjustment of real readings, for one or several stations: nonlinear, in condition form.
///
/// Minimises sum e_i^2 / sigma_i^2 over observations that meet all conditions f(y - e) = 0. Each step linearises at the
/// adjusted observations: e = Q C' (C Q C')^-1 (f + C e_before). The steps end at the Gauss-Newton solution of section
/// 4.3, without angles: a vertical hole is no special case. An observation that is left out has an unknown error
/// instead of a residual. Where 30 such steps do not converge (the residuals change the curvature at the minimum by
/// more than its own size, so that the steps go round the minimum), minimum.h finds the minimum.
#include <vector>

#include "reliability/observations.h"
#include "reliability/parity.h"

namespace surveymc::reliability {

/// Observations in this order: six readings of each station, then gravity, total field and dip, once for all stations,
/// if the references are observed; then, if systematic terms are estimated, biases (six) and scale factors (six) as
/// observations of value 0. Reading = (1 + scale) true + bias to first order in the scale.
struct StationReadings {
  std::vector<std::array<double, kReadings>> readings;  ///< m/s2, nT
  std::array<double, 3> references{};                   ///< m/s2, nT, rad: observed values, or true ones (mse_fixed)
};

/// Variances of the observation vector for error-free readings at the attitudes: eq 22. Modes other than mse_shared
/// take a single station.
Eigen::VectorXd adjustment_variances(const AdjustmentModel& model,
                                     const std::vector<std::array<double, kReadings>>& readings);

/// Number of an observation in the observation vector. For references `station` has no meaning.
Eigen::Index observation_number(const AdjustmentModel& model, std::size_t stations, std::size_t station,
                                std::size_t observation);

struct StationAdjustment {
  bool converged = false;
  int iterations = 0;
  double omega = 0;                         ///< sum of squared residuals in units of their variances
  Eigen::VectorXd residuals;                ///< e = y - adjusted y; of observations left out, their estimated error
  std::vector<survey::Attitude> attitudes;  ///< azimuths magnetic, in [0, 2 pi)
  std::array<double, 3> references{};
  ParityModel parity;  ///< at the solution, of the observations that were not left out
};

/// `left_out`: numbers of observations without weight (for sse_axial, bz is left out anyway). As long as the redundancy
/// is not exhausted the answer is unique. Throws std::invalid_argument if the number of stations does not go with the
/// model. `variances` from adjustment_variances, or your own.
StationAdjustment adjust(const AdjustmentModel& model, const StationReadings& y, const Eigen::VectorXd& variances,
                         const std::vector<Eigen::Index>& left_out = {});

/// The linear model at error-free readings, from which reliability is computed; its misclosures are zero.
ParityModel linear_model(const AdjustmentModel& model, const std::vector<survey::Attitude>& attitudes);

}  // namespace surveymc::reliability
