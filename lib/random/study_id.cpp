#include "random/study_id.h"

namespace surveymc::random {

// Two ids with one number do not compile: `case` values must differ.
std::string_view name_of(StudyId id) {
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
    case StudyId::error_model_monte_carlo:
      return "error_model_monte_carlo";
    case StudyId::clearance:
      return "clearance";
    case StudyId::collision:
      return "collision";
    case StudyId::rare_event:
      return "rare_event";
    case StudyId::reliability_map:
      return "reliability_map";
    case StudyId::reliability_well:
      return "reliability_well";
    case StudyId::gross_error_detection:
      return "gross_error_detection";
    case StudyId::corrected_codes:
      return "corrected_codes";
    case StudyId::robustness_map:
      return "robustness_map";
  }
  return "";
}

}  // namespace surveymc::random
