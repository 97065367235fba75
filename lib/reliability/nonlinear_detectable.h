#pragma once
/// Minimal detectable errors without linearisation.
///
/// Readings free of noise but for an error nabla in one of them are adjusted by the nonlinear model; what the residuals
/// show of it is sqrt(Omega(nabla)), the shift of the test. Linear theory has sqrt(Omega) = |nabla| / nabla_0 lambda_0.
/// Near weak geometry the error itself changes the geometry: the size that is detected then is another, finite where
/// the linear one is infinite, and depends on the sign.
#include "reliability/observations.h"

namespace surveymc {

/// sqrt(Omega) for an error of `nabla` (internal units) in one observation of a single station; the variances are
/// those of the error-free readings. NaN if the adjustment does not converge. Modes with one station, or mse_shared
/// with references to which the other stations add nothing (as sse with the sigmas of mse).
double error_shift(const AdjustmentModel& model, const Attitude& at, std::size_t observation, double nabla);

/// Smallest nabla > 0 (sign +1) or < 0 (sign -1) whose shift reaches lambda0; infinite if none up to 1e4 sd does, found
/// by steps of 10 % and then to 1e-10 of its size. Infinite as well where the adjustment stops converging before.
double nonlinear_detectable_error(const AdjustmentModel& model, const Attitude& at, std::size_t observation,
                                  double lambda0, int sign);

}  // namespace surveymc
