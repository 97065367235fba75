#pragma once
/// The observations of a survey station, their uncertainties, and the four ways of adjusting them.
/// Source of this module: Nyrnes, Torkildsen, Nahavandchi, "Detection of Gross Errors in Wellbore Directional
/// Surveying", Kart og Plan 65; equation, table and section numbers are theirs.
///
///   y = (gx, gy, gz, bx, by, bz, G, B, Theta): accelerometers (m/s2), magnetometers (nT) and three references:
///   gravity (m/s2), total field (nT), dip (rad). Unknown: inclination I, toolface tau, magnetic azimuth A, and the
///   true G, B, Theta where the references are observed.
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "base/units.h"
#include "survey/frames.h"
#include "survey/reference_field.h"

namespace surveymc::reliability {

/// Position of an observation in `y`.
enum class Observation : std::size_t { gx, gy, gz, bx, by, bz, gravity, total_field, dip };
inline constexpr std::size_t kObservations = 9;
inline constexpr std::size_t kReadings = 6;  ///< sensor readings of a station; the others are references

constexpr std::size_t index_of(Observation o) { return static_cast<std::size_t>(o); }
/// The axial magnetometer in matrices by readings, which axial correction leaves out.
inline constexpr int kAxialMagnetometer = static_cast<int>(index_of(Observation::bz));

/// "gx", ..., "bz", "gravity", "total_field", "dip".
const std::array<std::string, kObservations>& observation_names();
/// Unit in tables: "mps2", "nT" or "deg".
const std::string& observation_unit(std::size_t observation);
/// Internal unit (m/s2, nT, rad) in units of observation_unit(): 1, or degrees per radian.
double observation_scale(std::size_t observation);

/// What one of a relative observation is: the field's gravity or total field, or 1 rad.
double relative_unit(std::size_t observation, const survey::ReferenceField& field);

/// How a station is adjusted (sections 4.3, 5.1); n observations, u unknowns.
enum class AdjustmentMode {
  sse,        ///< one station, references observed; n/u = 9/6
  sse_axial,  ///< the same without bz (axial magnetic correction), as if bz had an unknown bias; 8/6
  mse_fixed,  ///< references free of error; 6/3
  mse_shared  ///< N stations share the observed references; (6N + 3)/(3N + 3)
};
/// "sse", "sse_axial", "mse_fixed", "mse_shared".
const std::vector<std::string>& adjustment_mode_names();
/// Throws std::out_of_range for another name.
AdjustmentMode adjustment_mode(const std::string& name);

/// One standard deviation each; the defaults are Table 1. m/s2, nT, rad; scale factors are pure numbers.
/// Eq 22: variance of a reading = bias^2 + (scale * reading)^2 + noise^2, with the reading that is free of noise.
struct SigmaModel {
  double accelerometer_bias = 0.0039, accelerometer_scale = 5e-4, accelerometer_noise = 0.003;
  double magnetometer_bias = 70, magnetometer_scale = 1.6e-3, magnetometer_noise = 70;
  double axial_interference = 150;  ///< added to the bias of bz in square
  double gravity = 0.003, total_field = 65, dip = 0.12 * kDegree;
};

/// The way of adjustment and its uncertainties. In the mse modes bias and scale factor do not enter the variances:
/// either the model leaves them out (as in the paper), or, with `systematic_terms`, they are the prior sd of twelve
/// unknowns common to all stations.
struct AdjustmentModel {
  AdjustmentMode mode = AdjustmentMode::sse;
  SigmaModel sigma = {};
  survey::ReferenceField field{9.82, 51000, 75 * kDegree, 0, 0};  ///< those of Table 1 and section 5.3
  int stations = 30;                                              ///< mse_shared: all of them
  bool systematic_terms = false;                                  ///< mse_shared only
  /// mse_shared, adjust() and linear_model() only: the readings are shots of one station, the tool turned between them.
  /// They share inclination and azimuth; N shots have (6N + 3)/(N + 5), and two conditions more for each but the first.
  bool rotational_shot = false;
};

/// True if the mode observes this quantity, that is, has a residual for it.
bool is_observed(AdjustmentMode mode, std::size_t observation);
/// The observed quantities of a mode, in the order of `y`.
std::vector<std::size_t> observed(AdjustmentMode mode);

using Observations = std::array<double, kObservations>;

/// y free of error at an attitude whose azimuth is magnetic (eqs 39-44).
Observations true_observations(const survey::Attitude& at, const survey::ReferenceField& field);

/// Variances of y for readings `y` (eq 22). Zero for references in mse_fixed. bz of sse_axial keeps its variance here;
/// the adjustment leaves bz out.
Observations observation_variances(const AdjustmentModel& model, const Observations& y);

/// Parts of eq 22 for one reading: {bias^2 + (scale y)^2, noise^2}.
struct VarianceParts {
  double systematic, noise;
};
VarianceParts variance_parts(const SigmaModel& sigma, std::size_t reading, double y);

}  // namespace surveymc::reliability
