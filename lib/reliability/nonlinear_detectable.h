#pragma once
/// Minimal detectable errors without linearisation.
///
/// Readings free of noise but for an error nabla in one observation are adjusted by the nonlinear model; what the
/// residuals show of it is sqrt(Omega(nabla)), the shift of the test. Linear theory has
/// sqrt(Omega) = |nabla| / nabla_0 lambda_0. Near weak geometry the error itself changes the geometry: the size that is
/// detected then is another, finite where the linear one is infinite, and depends on the sign.
///
/// mse_shared: the error is in one of N = model.stations stations at one attitude (or in a reference of all). The other
/// N - 1 are free of error and alike, so their adjusted readings are alike, too, and they weigh as one station with
/// variances divided by N - 1. Two stations with the shared references, and the systematic terms if they are estimated,
/// are thus the whole nonlinear adjustment, exactly; in linear theory that is one station with the reference covariance
/// S = (S_ref^-1 + (N-1) M_0^-1)^-1 of station_kernel.h.
#include "reliability/observations.h"

namespace surveymc {

/// sqrt(Omega) for an error of `nabla` (internal units) in one observation; the variances are those of the error-free
/// readings. NaN if the adjustment does not converge. Throws std::invalid_argument for an observation that the model
/// does not have.
double error_shift(const AdjustmentModel& model, const Attitude& at, std::size_t observation, double nabla);

/// Smallest nabla > 0 (sign +1) or < 0 (sign -1) whose shift reaches lambda0; infinite if none up to 1e4 sd does, found
/// by steps of 10 % and then to 1e-10 of its size. Infinite as well where the adjustment stops converging before.
double nonlinear_detectable_error(const AdjustmentModel& model, const Attitude& at, std::size_t observation,
                                  double lambda0, int sign);

}  // namespace surveymc
