#include "analysis/vertical_well_formulations.h"

#include <cassert>

#include "propagate/vertical_well.h"
#include "sensor/sensor_runs.h"

namespace surveymc::analysis {

const std::vector<std::string>& vertical_well_formulations() {
  static const std::vector<std::string> names{
      "toolface_dependent",                    // eqs 19, 20
      "fictive_terms",                         // eqs 36-40, correlation from the magnetic toolface
      "fictive_terms_accelerometer_toolface",  // the same, correlation from the accelerometers' toolface: a trap
      "ti_random",                             // eqs 41, 42
      "ti_systematic",                         // eqs 41, 42 as ISCWSA propagates them
      "spe_67616",                             // singular terms with A = alpha = 0
      "copegrove_without_half_leg",            // CDR-SM-03 rev 4 as printed: eqs 44, 46
      "copegrove_with_half_leg",               // with the missing dD/2
  };
  return names;
}

VerticalWellRun vertical_well_run(int legs, double spacing, const survey::ReferenceField& field, double bias_sd,
                                  const survey::ToolfacePlan& plan, const random::Stream& stream) {
  VerticalWellRun run;
  run.weights = propagate::vertical_station_weights(legs, spacing);
  run.tilt_sd = bias_sd / field.gravity;
  const survey::Vec3<double> bias{
      bias_sd * stream.normal(0, random::Channel::sensor_term, survey::kAccelerometerBias),
      bias_sd * stream.normal(0, random::Channel::sensor_term, survey::kAccelerometerBias + 1), 0};
  for (const double toolface : sensor::toolfaces_of_trial(plan, stream, 0)) {
    const survey::Attitude at{0, 0, toolface};
    const survey::Vec3<double> b = survey::magnetic_T(at, field.total, field.dip);
    run.magnetic_toolfaces.push_back(propagate::magnetic_toolface(b));
    run.accelerometer_toolfaces.push_back(
        survey::attitude_from_fields(scale(field.gravity, survey::down_T(at)) + bias, b).toolface);
  }
  return run;
}

Eigen::Matrix2d vertical_well_covariance(const std::string& name, const VerticalWellRun& r) {
  if (name == "toolface_dependent")
    return propagate::toolface_dependent_covariance(r.weights, r.magnetic_toolfaces, r.tilt_sd);
  if (name == "fictive_terms")
    return propagate::fictive_terms_covariance(r.weights, r.magnetic_toolfaces, r.magnetic_toolfaces, r.tilt_sd);
  if (name == "fictive_terms_accelerometer_toolface")
    return propagate::fictive_terms_covariance(r.weights, r.magnetic_toolfaces, r.accelerometer_toolfaces, r.tilt_sd);
  if (name == "ti_random")
    return propagate::random_covariance(propagate::toolface_independent_sources(r.weights, r.tilt_sd));
  if (name == "ti_systematic")
    return propagate::systematic_covariance(propagate::toolface_independent_sources(r.weights, r.tilt_sd));
  if (name == "spe_67616") return propagate::systematic_covariance(propagate::spe_67616_sources(r.weights, r.tilt_sd));
  const bool with_half_leg = name == "copegrove_with_half_leg";
  assert(with_half_leg || name == "copegrove_without_half_leg");
  return propagate::as_drilled_covariance(propagate::copegrove_sources(r.weights, r.tilt_sd, with_half_leg),
                                          r.magnetic_toolfaces);
}

}  // namespace surveymc::analysis
