#pragma once
/// The study that a draw belongs to. Two studies on one seed share no draw, because their ids differ.
#include <compare>
#include <cstdint>
#include <string_view>

namespace surveymc::random {

/// The numbers are part of every archived result: a study keeps its own for good, and a new study takes one that no
/// study ever had. At most 65535.
enum class StudyId : std::uint32_t {
  none = 0,  ///< no study: for values that were not read from a config
  msa_position = 1,
  msa_benefit = 2,
  drift_monitoring = 3,
  mwd_drift = 4,
  sensor_monte_carlo = 5,
  vertical_well = 6,
  estimate = 7,
  chained_multistation = 8,
  axial_correction = 9,
  position_covariance = 10,
  tool_code_map = 18,
  error_model_monte_carlo = 21,
  clearance = 23,
  collision = 26,
  rare_event = 27,
  reliability_map = 11,
  reliability_well = 12,
  gross_error_detection = 20,
  corrected_codes = 50,
  robustness_map = 52,
};

/// The study's name, as configs have it; "" of none.
std::string_view name_of(StudyId id);

/// The part of the address that all draws of one run of a study share.
struct StudySeed {
  std::uint64_t seed = 0;  ///< of the config
  StudyId study = StudyId::none;
  auto operator<=>(const StudySeed&) const = default;
};

}  // namespace surveymc::random
