#include "scenario/drilling.h"

#include <cmath>

#include "base/units.h"
#include "config/meanings.h"
#include "scenario/scenario.h"
#include "sensor/sensor_runs.h"

namespace surveymc::scenario {

survey::ToolfacePlan read_drilling(config::ConfigReader& c, const std::vector<double>& md, double toolface_zero,
                                   const random::Stream& stream, const std::vector<std::string>& modes) {
  const auto stations = static_cast<int>(md.size());
  const std::string mode =
      c.choice("drilling.mode", modes,
               "how the tool is turned: 'sliding': one toolface; 'rotating': toolfaces drawn at every station of every "
               "run; 'fixed_sequence' or 'random': drawn once, for all runs; 'mixed': slid at one toolface a run "
               "between two depths, rotated elsewhere; 'survey': the file's");
  const double toolface =
      c.has("drilling.toolface_deg")
          ? c.number("drilling.toolface_deg", config::Range::closed(-360, 360), config::meaning::kSlidingToolface) *
                    kDegree +
                toolface_zero
          : kNaN;
  const auto sequence =
      static_cast<std::uint64_t>(c.integer("drilling.sequence", 0, 1'000'000'000'000, config::meaning::kSequence, 0));
  const bool mixed = mode == "mixed";
  double from = 0, to = 0;
  if (mixed || c.has("drilling.slide_from_m"))
    from = c.number("drilling.slide_from_m", {},
                    "of mode 'mixed': measured depth where sliding begins; stations at it are slid");
  if (mixed || c.has("drilling.slide_to_m"))
    to = c.number("drilling.slide_to_m", {},
                  "of mode 'mixed': measured depth where sliding ends; stations at it are slid");
  if (mode == "sliding")
    return std::isnan(toolface) ? survey::slid(stations) : survey::constant_toolface(stations, toolface);
  if (mode == "fixed_sequence" || mode == "random") {
    survey::ToolfacePlan plan = survey::constant_toolface(stations, 0);
    plan.given = sensor::toolfaces_of_trial(survey::rotated(stations), stream, sequence);
    return plan;
  }
  if (!mixed) return survey::rotated(stations);
  c.require(to > from, "drilling.slide_to_m", "must be greater than slide_from_m");
  const survey::ToolfacePlan plan = survey::partly_slid(md, from, to);
  c.require(plan.has(survey::ToolfaceSource::slide), "drilling.slide_to_m",
            "no station lies between slide_from_m and this");
  return plan;
}

survey::Survey read_drilled_survey(config::ConfigReader& c, const survey::ReferenceField& field,
                                   random::StudySeed seed) {
  const std::string mode =
      c.has("drilling.mode")
          ? c.choice("drilling.mode", {"survey", "rotating", "sliding", "random"},
                     "toolfaces: 'survey': the file's; 'rotating': turned by 137.50776 deg from station to station; "
                     "'sliding': all `drilling.toolface_deg`; 'random': drawn once by the seed")
          : "survey";
  // Values that the mode does not use may stand there, so that it can be swept.
  const double toolface =
      c.has("drilling.toolface_deg")
          ? c.number("drilling.toolface_deg", config::Range::closed(-360, 360), config::meaning::kSlidingToolface) *
                kDegree
          : 0;
  const auto sequence =
      c.has("drilling.sequence")
          ? static_cast<std::uint64_t>(c.integer("drilling.sequence", 0, 1'000'000'000'000, config::meaning::kSequence))
          : 0;
  survey::Survey survey = read_survey(c, field, mode == "survey");
  if (mode == "survey") return survey;
  const int n = survey.size();
  std::vector<double> toolfaces(static_cast<std::size_t>(n));
  if (mode == "random") {
    if (!c.has("seed"))
      c.fail("drilling.mode", "toolfaces are drawn by the config's seed: give it, in the file's first lines");
    toolfaces = sensor::toolfaces_of_trial(survey::rotated(n), random::stream_of(seed), sequence);
  } else {
    const double zero =
        c.choice("survey.toolface_zero", {"x", "y"}, config::meaning::kToolfaceZero, "y") == "x" ? kPi / 2 : 0.0;
    const double golden = kPi * (3 - std::sqrt(5.0));
    for (int k = 0; k < n; ++k)
      toolfaces[static_cast<std::size_t>(k)] = mode == "sliding" ? toolface + zero : std::fmod(k * golden, 2 * kPi);
  }
  for (std::size_t k = 0; k < toolfaces.size(); ++k) survey.stations[k].toolface = toolfaces[k];
  return survey;
}

survey::SensorTermArray read_sensor_errors(config::ConfigReader& c) {
  const double multiplier =
      c.number("sensor_errors.multiplier", config::Range::positive(), "multiplies all sensor errors", 1);
  const auto size = [&](const char* key, double most) {
    return multiplier * c.number(std::string("sensor_errors.") + key, config::Range::closed(0, most),
                                 "one sd of this error of each sensor of this kind, constant in a run", 0);
  };
  const double accelerometer_bias = size("accelerometer_bias_mps2", 1),
               accelerometer_scale = size("accelerometer_scale", 0.1),
               magnetometer_bias = size("magnetometer_bias_nT", 1e5),
               magnetometer_scale = size("magnetometer_scale", 0.1);
  return survey::equal_axes(accelerometer_bias, accelerometer_scale, magnetometer_bias, magnetometer_scale);
}

}  // namespace surveymc::scenario
