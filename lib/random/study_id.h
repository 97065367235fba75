#pragma once
/// Which study a draw belongs to. Two studies on one seed share no draw, because their ids differ.
#include <cstdint>
#include <string_view>

namespace surveymc::random {

/// The numbers are part of every archived result: a study keeps its own for good, and a new study takes one that no
/// study ever had. At most 65535.
enum class StudyId : std::uint32_t {
  none = 0,  ///< no study: of values that were not read from a config
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
  reliability_map = 11,
  reliability_well = 12,
  tool_code_map = 18,
  gross_error_detection = 20,
};

/// The study's name, as configs have it. Two ids with one number do not compile: `case` values must differ.
constexpr std::string_view name_of(StudyId id) {
  switch (id) {
    case StudyId::none:
      break;
    case StudyId::msa_position:
      return "msa_position";
    case StudyId::msa_benefit:
      return "msa_benefit";
    case StudyId::drift_monitoring:
      return "drift_monitoring";
    case StudyId::mwd_drift:
      return "mwd_drift";
    case StudyId::sensor_monte_carlo:
      return "sensor_monte_carlo";
    case StudyId::vertical_well:
      return "vertical_well";
    case StudyId::estimate:
      return "estimate";
    case StudyId::chained_multistation:
      return "chained_multistation";
    case StudyId::axial_correction:
      return "axial_correction";
    case StudyId::position_covariance:
      return "position_covariance";
    case StudyId::tool_code_map:
      return "tool_code_map";
    case StudyId::reliability_map:
      return "reliability_map";
    case StudyId::reliability_well:
      return "reliability_well";
    case StudyId::gross_error_detection:
      return "gross_error_detection";
  }
  return "";
}

/// What all draws of one run of a study have in common.
struct StudySeed {
  std::uint64_t seed = 0;  ///< of the config
  StudyId study = StudyId::none;
};

}  // namespace surveymc::random
