#pragma once
/// Effect of an error of given size, in one observation of a station or in several at once, on the residuals and on the
/// estimates: e = R c nabla (eq 21; section 3.1 and figure 1). Also the weakest combination of observations.
///
/// Linear, in condition form, with the weights W and W_N of station_kernel.h. For errors eps of the readings and of the
/// references, with columns c, and their sums over the N stations,
///   k = W C eps_readings + W_N C eps_references,   k_sum = W_N C eps_readings + N W_N C eps_references
///   residual of a reading = v c'k,   of a reference = v c'k_sum
/// and the rest of the error in the readings turns the attitude. One station: W = W_N.
#include <Eigen/Core>

#include "reliability/observations.h"
#include "reliability/station_kernel.h"

namespace surveymc::reliability {

/// Sines and cosines with exact right angles, so that the effect on an undefined angle is infinite, and not merely
/// large.
StationSines<double> station_sines(double inclination_deg, double toolface_deg, double magnetic_azimuth_deg,
                                   double dip_deg);

/// Effects of an error. Internal units (m/s2, nT, rad).
struct ErrorResponse {
  Observations residuals;  ///< e = y - adjusted y; NaN where the mode has no such observation
  double inclination, toolface, azimuth;
  double gravity, total_field, dip;  ///< 0 where references are free of error
};

/// One station, or one of `model.stations` at the same attitude (mse_shared); all stations share an error in a
/// reference. `sines` must have the dip of model.field.
class StationResponse {
 public:
  using Matrix9 = Eigen::Matrix<double, kObservations, kObservations>;

  StationResponse(const AdjustmentModel& model, const StationSines<double>& sines);

  /// sd of the observations in the adjustment, the unit of combinations. 0 for references free of error.
  Observations sd() const;

  /// H with z'Hz = lambda^2, the noncentrality of a test for the error z that is given in sd of the observations. Its
  /// diagonal are the redundancy numbers; rows of observations that the mode has not are zero.
  Matrix9 information() const;

  /// Response to errors `error` (internal units) in all observations together. An effect on toolface or azimuth is
  /// infinite where the angle has no value (vertical hole; without bz in a horizontal hole to the east or west), unless
  /// the error has no effect on the angle. Errors of observations that the mode does not have must be 0.
  ErrorResponse of(const Observations& error) const;

 private:
  using Vector3 = Eigen::Vector3d;
  using Vector9 = Eigen::Matrix<double, kObservations, 1>;
  using Columns = Eigen::Matrix<double, 3, kObservations>;

  Vector9 unit_;        ///< of the observations, in internal units: G, B, 1
  Columns columns_;     ///< c, per relative error
  Vector9 variance_;    ///< v, relative; of the noise where systematic terms are estimated
  Vector9 systematic_;  ///< variance of a reading's systematic terms where they are estimated
  Eigen::Matrix3d weight_, weight_sum_;
  Vector3 of_bz_;  ///< estimated error of bz = -of_bz_' (C eps) where it is left out; else 0
  bool azimuth_is_lost_ = false;
  StationSines<double> sines_;
  double stations_;
  AdjustmentMode mode_;
};

/// Of all errors of length 1 in some observations, measured in sd, the one to which the tests respond least: the
/// direction Z of the smallest eigenvalue of the information. Where they respond equally little to several (for example
/// not at all), the one nearest to a single observation.
struct WeakestDirection {
  double redundancy;          ///< z'Hz; 0 below 1e-10
  Eigen::VectorXd direction;  ///< unit vector, in sd; the largest entry, of equal ones the first, is positive
  Eigen::Index dimensions;    ///< number of directions with any response: r of the test of all of them together (eq 4)
};
WeakestDirection weakest_direction(const Eigen::MatrixXd& information);

}  // namespace surveymc::reliability
