#pragma once
/// Minimal detectable errors without linearisation.
///
/// Readings without noise, but with an error nabla in one observation, are adjusted by the nonlinear model. Whether the
/// error is detected depends on the test:
///   nabla shifts the general test (Omega, with the level of the B-method) by sqrt(Omega(nabla)),
///   and the observation's own test by |w_i(nabla)|, which is at most sqrt(Omega(nabla)).
/// Linear theory has |nabla| / nabla_0 lambda_0 for both. Near weak geometry the error itself changes the geometry. The
/// detectable size then differs: it is finite where the linear one is infinite, and depends on the sign and on the
/// test, because the error may show in full, but in the tests of other observations.
///
/// mse_shared: the error is in one of N = model.stations stations at one attitude (or in a reference of all). The other
/// N - 1 are free of error and alike, so their adjusted readings are alike, too, and they count as one station with
/// variances divided by N - 1. So an adjustment of two stations with the shared references, and the systematic terms if
/// they are estimated, is exactly that of all N. In linear theory it equals one station with the reference covariance
/// S = (S_ref^-1 + (N-1) M_0^-1)^-1 of station_kernel.h.
#include <Eigen/Core>

#include "reliability/observations.h"

namespace surveymc::reliability {

/// The test that has to find the error.
enum class DetectedBy { general_test, own_test };

/// Shifts of both tests. NaN where the adjustment does not converge; own: 0 where the observation has no test.
struct TestShift {
  double general, own;
  double by(DetectedBy test) const { return test == DetectedBy::general_test ? general : own; }
};

/// Shifts by an error of `nabla` (internal units) in one observation; the variances are those of the error-free
/// readings. Adjusted by Gauss-Newton steps, and by minimum.h where these do not settle, or where the bz of sse_axial
/// does not enter the conditions to first order (horizontal, east or west), so that no step moves it. Throws
/// std::invalid_argument for an observation that the model does not have.
TestShift error_shift(const AdjustmentModel& model, const survey::Attitude& at, std::size_t observation, double nabla);

/// Smallest nabla > 0 (sign +1) or < 0 (sign -1) whose shift reaches lambda0; infinite if none up to 1e4 sd does. The
/// search takes steps of 10 % and then goes to 1e-10 of the size. Not all larger errors need be detectable: a shift may
/// fall again.
double nonlinear_detectable_error(const AdjustmentModel& model, const survey::Attitude& at, std::size_t observation,
                                  double lambda0, int sign, DetectedBy test = DetectedBy::general_test);

/// A station of a well whose shared quantities z (references; with systematic terms 12 more) are known with a full
/// covariance. `shared` holds the information of the other stations (minimum.h; 0 x 0: mode other than mse_shared).
struct StationInWell {
  AdjustmentModel model;
  survey::Attitude at;  ///< azimuth magnetic
  Eigen::MatrixXd shared;
};

/// The smallest error of such a station that is found, and the station as adjusted with it.
struct DetectedError {
  double size = 0;                ///< signed, internal units; infinite as above
  Eigen::Vector3d down, field;    ///< of the adjusted readings, tool frame, less systematic terms; m/s2, nT
  Eigen::VectorXd shared_errors;  ///< estimated errors of z: observed less adjusted, and the systematic terms
};
DetectedError detected_error(const StationInWell& station, std::size_t observation, double lambda0, int sign,
                             DetectedBy test);
/// The same for a single station, or for one of model.stations at one attitude.
DetectedError detected_error(const AdjustmentModel& model, const survey::Attitude& at, std::size_t observation,
                             double lambda0, int sign, DetectedBy test);

/// Change of the angles of `at` by the error: inclination, toolface, azimuth in (-pi, pi]; NaN where the angle has no
/// value, infinite where the error is infinite.
struct AngleEffects {
  double inclination, toolface, azimuth;
};
AngleEffects angle_effects(const survey::Attitude& at, const DetectedError& error);

}  // namespace surveymc::reliability
