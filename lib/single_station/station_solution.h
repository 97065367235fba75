#pragma once
/// One station by itself: attitude and field from six readings and the references of gravity and field.
///
/// Source: slides on chained multistation analysis, 1 to 6. They use A = -g_T (specific force), H = b_T and a toolface
/// HTF from x; all code is in the frame of survey/frames.h, HTF = tau - 90 deg.
///
///   basic        inclination and toolface from the accelerometers; then the field is linear in Bh cosA, Bh sinA, Bd
///   simple       Bd is known, an axial magnetisation Mz of the string is not: fails where cos I = 0, at every azimuth
///   extended     weighted least squares in (Bh cosA, Bh sinA, Bd, Mz) with Bd = Bd_ref and Mz = 0 as observations
///   extended_bh  the same with Bh = Bh_ref too, its row (cosA, sinA, 0, 0)
///   optimising   fully optimising: gravity with its reference in (toolface, g_xy, g_z), row (0, g_xy/g, g_z/g), then
///                the field in (Bh cosA, Bh sinA, Bd) with Bh and Bd as observations; no Mz
///
/// Inclination and toolface are held fixed while the field is solved for, as on the slides; the covariance includes the
/// effect of their errors on the field. References are independent of each other.
#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "survey/frames.h"
#include "survey/station_readings.h"

namespace surveymc::single_station {

enum class StationMethod { basic, simple, extended, extended_bh, optimising };
inline constexpr std::size_t kStationMethods = 5;

/// "basic", "simple", "extended", "extended_bh", "optimising", in the order of StationMethod.
const std::vector<std::string>& station_method_names();
/// Throws InputError on an unknown name.
StationMethod station_method(const std::string& name);

/// One standard deviation each. All are finite; those of the magnetometers, and of the references that a method
/// observes, are positive.
struct StationSigmas {
  double accelerometer_xy = 0, accelerometer_z = 0;  ///< m/s2, per axis
  double magnetometer_xy = 0, magnetometer_z = 0;    ///< nT, per axis
  double gravity = 0;                                ///< of the reference, m/s2
  double horizontal = 0, vertical = 0;               ///< of the references Bh and Bd, nT
  double axial = 0;                                  ///< of the axial magnetisation Mz, nT
};

struct StationReferences {
  double gravity = 0;                   ///< m/s2
  double horizontal = 0, vertical = 0;  ///< Bh, Bd, nT
};

/// Throws InputError where the method cannot work with the sigmas: one is negative or not finite, that of a
/// magnetometer is 0, or that of a reference that pulls to a circle (Bh; gravity of optimising, with its
/// accelerometers) is 0.
void check_sigmas(const StationSigmas& sigmas, StationMethod method);

/// Rows of a covariance. `turn` is azimuth + toolface below the horizontal and azimuth - toolface above it: this angle
/// stays defined in a vertical hole, where azimuth and toolface are not.
enum class StationQuantity { inclination, toolface, azimuth, turn, gravity, horizontal, vertical, axial };
using StationCovariance = Eigen::Matrix<double, 8, 8>;

struct StationSolution {
  bool determined = false;    ///< false: no gravity or no horizontal field; cos I = 0 (simple); two equal minima (Bh)
  survey::Attitude attitude;  ///< azimuth magnetic, in [0, 2 pi); toolface 0 in a vertical hole
  double gravity = 0;         ///< m/s2
  double north = 0, east = 0, vertical = 0;  ///< Bh cosA, Bh sinA, Bd, nT
  double axial = 0;                          ///< Mz, nT; 0 for basic and optimising
  double misclosure = 0;                     ///< Bd_ref less the vertical field of the uncorrected readings, nT
  double cost = 0;                           ///< weighted sum of squares of the field's adjustment at the minimum
  int redundancy = 0;                        ///< observations less unknowns of the field

  double horizontal() const { return std::hypot(north, east); }
};

/// g_T in m/s2 pointing down, b_T in nT. Throws InputError like check_sigmas.
StationSolution solve_station(const survey::Vec3<double>& g_T, const survey::Vec3<double>& b_T,
                              const StationReferences& references, const StationSigmas& sigmas, StationMethod method);

/// First-order effect of the errors of the inputs on the solution: 8 quantities by the inputs
///   0-2  accelerometers: outwards (along -(sin tau, cos tau)), across (along -(cos tau, -sin tau)), z
///   3    gravity reference
///   4-6  magnetometers: along (sin tau, cos tau), across (cos tau, -sin tau), z
///   7 Mz,  8 Bd_ref,  9 Bh_ref
/// in rad and the units above. The row of Mz is the error of its estimate. In a vertical hole azimuth and toolface have
/// an infinite entry 1.
using StationGains = Eigen::Matrix<double, 8, 10>;
StationGains station_gains(const StationSolution& solution, const StationSigmas& weights, StationMethod method);

/// Covariance of the solution when the inputs have the standard deviations `actual` (by default those that the method
/// weighs with). Inputs without error add nothing, even where their gain is infinite; a variance may be infinite.
StationCovariance station_covariance(const StationSolution& solution, const StationSigmas& weights,
                                     StationMethod method, const StationSigmas& actual);
inline StationCovariance station_covariance(const StationSolution& solution, const StationSigmas& weights,
                                            StationMethod method) {
  return station_covariance(solution, weights, method, weights);
}

/// Whether a determined solution fits its sigmas: chi-squared with `redundancy` degrees of freedom to first order; NaN
/// without redundancy. The misclosures m of the references, Bd_ref - Bd and Bh_ref - Bh, have the covariance C by all
/// inputs, and the statistic is m^T C^-1 m. It is `cost` if the accelerometers are exact: the cost takes the attitude
/// as known, while an error of the inclination moves Bd by Bh cosA of it.
double fit_statistic(const StationSolution& solution, const StationReferences& references, const StationSigmas& sigmas,
                     StationMethod method);

/// Rows of the solutions of many trials; station k of a batch starts at row k kStationSolutionRows.
inline constexpr int kAxesRow = 0;    ///< sin, cos of the inclination, sin, cos of the toolface
inline constexpr int kTotalRow = 4;   ///< gravity, m/s2
inline constexpr int kNorthRow = 5;   ///< Bh cosA, Bh sinA, Bd, Mz, nT
inline constexpr int kCostRow = 9;    ///< see StationSolution
inline constexpr int kFoundRow = 10;  ///< 1, or 0 where the method gives no answer
inline constexpr int kStationSolutionRows = 11;

/// Solves all stations of a block by one method: lane i of the result is bit for bit solve_station() of trial i.
/// Throws InputError like check_sigmas.
survey::LaneArray solve_stations(const survey::LaneArray& readings, int stations, int groups,
                                 const StationSigmas& sigmas, StationMethod method);

}  // namespace surveymc::single_station
