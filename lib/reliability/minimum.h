#pragma once
/// The minimum of an adjustment where Gauss-Newton steps do not settle.
///
/// Unknowns are the directions of each station in the tool frame, F = [north east down], and the quantities that all
/// stations share: z = (G, B, Theta, biases, scale factors), where the model estimates them. With
///   g = G down,  b = B (cos Theta north + sin Theta down),  reading = ((g, b) + bias) / (1 - scale)
/// no angle is singular. A step turns F by a small vector phi (F <- exp([phi]) F) and moves z.
///   Omega = sum ((reading - adjusted) / sd)^2 + (z_0 - z)' Cov(z_0)^-1 (z_0 - z)
/// Omega falls from step to step towards a stationary point, from any start (stats/descent.h; H: second derivatives of
/// Omega / 2, exact for directions and references, of first order for systematic terms and between shots). If this
/// point has a direction of negative curvature, the search leaves it along this direction.
#include <optional>

#include "reliability/adjustment.h"

namespace surveymc::reliability {

struct Minimum {
  bool converged = false;
  int steps = 0;  ///< tried, taken or not
  double omega = 0;
  Eigen::VectorXd adjusted;  ///< in the order of adjustment_variances
};

/// Starts at the directions that the readings give and at the observed z. `left_out`: observations without weight; bz
/// of sse_axial is one of them anyway. `shared_covariance`: Cov(z_0) in place of the diagonal one of `variances`, for
/// all of z (3 x 3, 15 x 15 with systematic terms); a variance of zero keeps its entry as observed.
/// Converged: the last step, undamped, moved no observation by more than 1e-7 sd, that is, within 1e-14 of Omega.
Minimum minimum_of_omega(const AdjustmentModel& model, const StationReadings& y, const Eigen::VectorXd& variances,
                         const std::vector<Eigen::Index>& left_out = {},
                         const std::optional<Eigen::MatrixXd>& shared_covariance = {});

}  // namespace surveymc::reliability
