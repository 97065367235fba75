#pragma once
/// One station by itself: attitude and field from six readings and the references of gravity and field.
///
/// Source: slides on chained multistation analysis, 1 to 6. They use A = -g_T (specific force), H = b_T and a toolface
/// HTF from x; here everything is in the frame of survey/frames.h, HTF = tau - 90 deg.
///
///   basic        inclination and toolface from the accelerometers; then the field is linear in Bh cosA, Bh sinA, Bd
///   simple       Bd is known, an axial magnetisation Mz of the string is not: fails where cos I = 0, whatever azimuth
///   extended     weighted least squares in (Bh cosA, Bh sinA, Bd, Mz) with Bd = Bd_ref and Mz = 0 as observations
///   extended_bh  the same with Bh = Bh_ref too, its row (cosA, sinA, 0, 0)
///   optimising   fully optimising: gravity with its reference in (toolface, g_xy, g_z), row (0, g_xy/g, g_z/g), then
///                the field in (Bh cosA, Bh sinA, Bd) with Bh and Bd as observations; no Mz
///
/// Inclination and toolface are held while the field is solved for, as on the slides; the covariance says what their
/// errors do to it. References are independent of each other.
#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "survey/frames.h"

namespace surveymc::single_station {

enum class StationMethod { basic, simple, extended, extended_bh, optimising };
inline constexpr std::size_t kStationMethods = 5;

/// "basic", "simple", "extended", "extended_bh", "optimising", in the order of StationMethod.
const std::vector<std::string>& station_method_names();
/// Throws InputError on an unknown name.
StationMethod station_method(const std::string& name);

/// One standard deviation each. Finite; magnetometers positive, and what a method observes as well.
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

/// Throws InputError where the sigmas are none that the method can work with: negative or not finite, magnetometers 0,
/// or a reference that it pulls to a circle (Bh; gravity of optimising, with its accelerometers) 0.
void check_sigmas(const StationSigmas& sigmas, StationMethod method);

/// Rows of a covariance. `turn` is azimuth + toolface below the horizontal and azimuth - toolface above it: the angle
/// that stays defined in a vertical hole, where the other two are not.
enum class StationQuantity { inclination, toolface, azimuth, turn, gravity, horizontal, vertical, axial };
inline constexpr std::size_t kStationQuantities = 8;
using StationCovariance = Eigen::Matrix<double, 8, 8>;

struct StationSolution {
  bool determined = false;    ///< false: no gravity or no horizontal field; cos I = 0 (simple); two equal minima (Bh)
  survey::Attitude attitude;  ///< azimuth magnetic, in [0, 2 pi); toolface 0 in a vertical hole
  double gravity = 0;         ///< m/s2
  double north = 0, east = 0, vertical = 0;  ///< Bh cosA, Bh sinA, Bd, nT
  double axial = 0;                          ///< Mz, nT; 0 of basic and optimising
  double misclosure = 0;                     ///< Bd_ref less the vertical field of the readings as they are, nT
  double cost = 0;                           ///< weighted sum of squares of the field's least squares at the minimum
  int redundancy = 0;                        ///< its observations less its unknowns: chi-squared with so many degrees

  double horizontal() const { return std::hypot(north, east); }
};

/// g_T in m/s2 pointing down, b_T in nT. Throws InputError like check_sigmas.
StationSolution solve_station(const survey::Vec3<double>& g_T, const survey::Vec3<double>& b_T,
                              const StationReferences& references, const StationSigmas& sigmas, StationMethod method);

/// What the errors of the inputs do to the solution, to first order: 8 quantities by the inputs
///   0-2 accelerometers: outwards (along -(sin tau, cos tau)), across (along -(cos tau, -sin tau)), z;  3 gravity
///   reference 4-6 magnetometers: along (sin tau, cos tau), across (cos tau, -sin tau), z;  7 Mz;  8 Bd_ref;  9 Bh_ref
/// in rad and the units above. Of Mz the error of its estimate. In a vertical hole azimuth and toolface have an
/// infinite entry 1.
using StationGains = Eigen::Matrix<double, 8, 10>;
StationGains station_gains(const StationSolution& solution, const StationSigmas& weights, StationMethod method);

/// Covariance of the solution when the inputs have the standard deviations `actual` (by default those that the method
/// weighs with). Inputs without error do not count, even where their gain is infinite; a variance may be infinite.
StationCovariance station_covariance(const StationSolution& solution, const StationSigmas& weights,
                                     StationMethod method, const StationSigmas& actual);
inline StationCovariance station_covariance(const StationSolution& solution, const StationSigmas& weights,
                                            StationMethod method) {
  return station_covariance(solution, weights, method, weights);
}

}  // namespace surveymc::single_station
