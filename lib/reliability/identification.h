#pragma once
/// How often some test rejects, and which test is then the largest, by linear theory.
#include "reliability/parity.h"

namespace surveymc::reliability {

struct LinearRates {
  double any = 0;         ///< probability that some |w| is above the critical value
  double identified = 0;  ///< that, and the largest |w| is that of observation `number`, or of one tied with it
};

/// Rates for errors that shift the whitened misclosures by `shift`: t = shift + N(0, 1), w_i = a_i.t / |a_i|. For
/// three conditions: along a ray t = R d the largest test is always the same and rejects beyond one R, so the radial
/// integral is closed; the directions are rings of equal probability about the shift. The union of the correlated tests
/// is thus integrated, not summed, and both rates are in [0, 1]. Both are good to 2e-4, `any` without a shift to 1 % of
/// itself. NaN for another number of conditions.
LinearRates linear_rates(const ParityModel& model, const Eigen::VectorXd& shift, Eigen::Index number, double critical);

}  // namespace surveymc::reliability
