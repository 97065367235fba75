#pragma once
/// ISCWSA weighting functions of magnetic (MWD) surveys: how a unit of an error source changes measured depth,
/// inclination and azimuth of a station. A fixed set with fixed names; models choose among them (error_model.h).
///
/// Notation: I inclination, A true azimuth, Am magnetic azimuth, G gravity, B total field, D dip (positive down).
/// Azimuth weights w_A become singular in a vertical hole, where only sinI w_A moves the hole. So each function gives
/// sinI w_A, in closed form: nothing is singular, and the limit at I = 0 is the published vertical branch.
#include <span>
#include <string>

#include <Eigen/Core>

namespace surveymc::propagate {

/// What the weighting functions need of one station (SI).
struct StationGeometry {
  double sin_i, cos_i;
  double sin_a, cos_a;    ///< true azimuth
  double sin_am, cos_am;  ///< magnetic azimuth
  double gravity, tan_dip, horizontal_field;
  double md, tvd;
  double dmd;                 ///< length of the leg before the station
  double inclination_change;  ///< over that leg, absolute, rad
  double azimuth_turn;  ///< |sinI sin(A - A before)|; 0 when the leg begins vertical (azimuth means nothing there)
};

/// Effect of one unit of the error source.
struct Weights {
  double depth = 0;        ///< m
  double inclination = 0;  ///< rad
  double lateral = 0;      ///< sinI w_A, rad
};

/// What the magnitude of a source measures.
enum class Quantity { length, per_length, ratio, acceleration, magnetic_field, angle, angle_by_field };

struct WeightingFunction {
  const char* name;
  Quantity quantity;
  /// False: an error of the station's measurement, which moves the hole on both sides of it. True (XCLA, XCLH): an
  /// error of the course between two stations; the weights are metres of lateral (right) and high-side displacement at
  /// the end of the leg before the station, and nothing beyond it.
  bool is_course;
  Weights (*weights)(const StationGeometry&);
};

/// All of them, by name: DREF DSF DST, ABXY-TI1 ... MSZ, AZ DBH AMIL, SAG SAGE, XYM1 ... XYM4E, XCLA XCLH.
std::span<const WeightingFunction> weighting_functions();
/// Null if there is none of this name.
const WeightingFunction* find_weighting_function(const std::string& name);

/// Least tortuosity that XCLA and XCLH assume: 1 deg / 100 ft, in rad/m (5.72614584e-4).
extern const double kLeastTortuosity;
/// Inclination (rad) below which a leg's begin counts as vertical for XCLA: 0.0001 deg, as in the ISCWSA workbooks.
extern const double kVerticalLimit;

}  // namespace surveymc::propagate
