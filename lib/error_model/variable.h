#pragma once
/// What a formula of a weighting function may name.
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "error_model/dimension.h"

namespace surveymc::error_model {

/// Values are SI with seconds: metres, radians, nanotesla, m/s2, rad/s, m/s. In three groups: what changes from station
/// to station; what belongs to the well or the model; the value of a running sum.
enum class Variable {
  // of the station
  md,                  ///< MD
  md_before,           ///< MDPrev: of the station before
  tvd,                 ///< TVD
  inclination,         ///< Inc
  inclination_before,  ///< IncPrev
  azimuth,             ///< AzT, Az: from true north
  azimuth_before,      ///< AzPrev: within 180 deg of AzT, and AzT where the station before is vertical
  azimuth_magnetic,    ///< AzM
  noise_reduction,     ///< NoiseReductionFactor, as the gyro's mode at the station has it
  running_speed,       ///< RunningSpeed of the zone of the gyro that the station is in
  sin_inclination,     ///< these six have no name: the graph takes them for Sin(Inc) ... Cos(AzM)
  cos_inclination,
  sin_azimuth,
  cos_azimuth,
  sin_azimuth_magnetic,
  cos_azimuth_magnetic,
  // of the well and of the model
  dip,                ///< Dip
  total_field,        ///< BField
  gravity,            ///< GField
  latitude,           ///< Latitude
  earth_rate,         ///< EarthRate
  min_course_length,  ///< MinCourseLength
  tortuosity,         ///< XCLTortuosity
  // of the function
  previous  ///< Previous: what this formula gave one station before
};
inline constexpr std::size_t kStationVariables = 16;
inline constexpr std::size_t kVariables = 24;
constexpr std::size_t index_of(Variable v) { return static_cast<std::size_t>(v); }
constexpr bool is_of_station(Variable v) { return index_of(v) < kStationVariables; }

/// Rotation of the earth, rad/s: 15.041067 deg/h.
extern const double kEarthRate;

/// The variable of a name or an alias of it; capital and small letters are the same. Nothing for an unknown name.
std::optional<Variable> find_variable(std::string_view name);
/// The name that formulas write.
std::string variable_name(Variable v);
/// Names without aliases, for suggestions.
const std::vector<std::string>& variable_names();
/// Not for Variable::previous, whose dimension its formula decides.
Dimension dimension_of(Variable v);

/// True if two names differ in capital and small letters at most.
bool same_name(std::string_view a, std::string_view b);

}  // namespace surveymc::error_model
