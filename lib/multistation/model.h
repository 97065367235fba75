#pragma once
/// The model of multi-station analysis with any parameters of the table, for one station: corrected readings, residuals
/// and their derivatives in closed form. Readable form, by Eigen; the kernel on lanes is fit_kernel.h.
///
/// With the corrected g = A^-1 (g_read - ab), b = M^-1 (b_read - mb) (parameters.h) and u = g / |g|, Bv = u.b,
/// h = (b - Bv u) / Bh, s = Bv / |b|:
///   survey       r = ((|g| - G) / s_g, (Bh - Bh_ref) / s_h, (Bv - Bv_ref) / s_v)
///   calibration  r = ((|g| - G) / s_g, (|b| - B_ref) / s_h, (s - s_ref) / s_v)
/// Calibration is for shots at unknown attitudes in an unknown field: |b|, |g| and the angle between both are the same
/// at all. Derivatives, exact with g and b as corrected:
///   d|g| = u.dg,  du = (1 - uu') dg / |g|,  dBh = h.db - Bv h.du,  dBv = u.db + Bh h.du
///   d|b| = b.db / |b|,  ds = (u - s b / |b|).db / |b| + (b / |b| - s u).dg / |g|
///   dg = -A^-1 (dA g + dab),  db = -M^-1 (dM b + dmb)
#include <vector>

#include <Eigen/Core>

#include "multistation/parameters.h"
#include "survey/frames.h"

namespace surveymc::multistation {

enum class ResidualKind { survey, calibration };

/// Rows of residuals: gravity; then horizontal field or total field; then vertical field or sine of the angle between
/// field and gravity (the dip).
inline constexpr int kResiduals = 3;

/// What the readings of a station are compared with. `first`: Bh_ref, or B_ref (nT); `second`: Bv_ref (nT), or s_ref.
struct Reference {
  double gravity = 9.80665;  ///< m/s2
  double first = 0, second = 0;
};
/// Of a total field (nT) and a dip (rad).
Reference reference_of(ResidualKind kind, double gravity, double total, double dip);

/// One station: readings in the tool frame, gravity (m/s2) pointing down, field in nT.
struct StationReadings {
  survey::Vec3<double> gravity_T, magnetic_T;
  Reference reference;
};

/// Sizes of the residuals, one standard deviation: gravity (m/s2), horizontal or total field (nT), vertical field (nT)
/// or sine of the angle.
using ResidualSizes = std::array<double, kResiduals>;

/// A triad's errors as one matrix and one bias: reading = matrix value + bias.
struct TriadErrors {
  Eigen::Matrix3d matrix;
  Eigen::Vector3d bias;
};
TriadErrors accelerometer_errors(const PerParameter<double>& parameters);
TriadErrors magnetometer_errors(const PerParameter<double>& parameters);

/// Readings by a tool with these errors of the true `gravity` and `field`.
StationReadings readings_of(const PerParameter<double>& tool, const Eigen::Vector3d& gravity_T,
                            const Eigen::Vector3d& field_T, const Reference& reference);

/// Residuals of a station, in units of `sizes`, and their derivatives.
struct StationModel {
  Eigen::Vector3d gravity_T, field_T;  ///< corrected
  /// Of the corrected vectors by the parameters of the table, a column each, and by the readings.
  Eigen::Matrix<double, 3, kParameters> gravity_by_parameter, field_by_parameter;
  Eigen::Matrix3d gravity_by_reading, field_by_reading;
  Eigen::Vector3d residual;                                     ///< in units of the sizes
  Eigen::Matrix<double, kResiduals, kParameters> by_parameter;  ///< a column a parameter of the table, per its unit
  Eigen::Matrix3d by_gravity, by_magnetic;                      ///< per m/s2, nT of a reading
  Eigen::Matrix3d by_reference;                                 ///< per unit of Reference's three values
};
StationModel station_model(const StationReadings& station, const PerParameter<double>& parameters, ResidualKind kind,
                           const ResidualSizes& sizes);

/// Residuals alone.
Eigen::Vector3d station_residual(const StationReadings& station, const PerParameter<double>& parameters,
                                 ResidualKind kind, const ResidualSizes& sizes);

/// Derivatives of all stations' residuals by the parameters of a set: three rows a station, a column a parameter.
Eigen::MatrixXd jacobian(const std::vector<StationReadings>& stations, const PerParameter<double>& parameters,
                         const ParameterSet& set, ResidualKind kind, const ResidualSizes& sizes);

}  // namespace surveymc::multistation
