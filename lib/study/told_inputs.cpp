#include "study/told_inputs.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/error.h"
#include "base/units.h"
#include "config/survey_checks.h"
#include "survey/survey_summary.h"

namespace surveymc::study {

const char* north_name(config::AzimuthReference north) {
  return north == config::AzimuthReference::magnetic ? "magnetic"
         : north == config::AzimuthReference::grid   ? "grid"
                                                     : "true";
}

void tell_survey(config::ConfigReader& c, const config::InputTable& table, const survey::Survey& survey,
                 const config::SurveyConventions& conventions, const std::string& unusual) {
  // The key is asked for by has() first, so that no default of it is written into every config.
  const bool allowed = c.has(unusual) && c.choice(unusual, {"refuse", "allow"}) == "allow";
  for (const config::SurveyFinding& f : config::unusual_in_survey(table, survey)) {
    if (f.is_refused && !allowed)
      throw InputError(fmt::format("{}; if the survey is meant so, set {} = \"allow\"", f.text, unusual));
    c.warn("", f.text);
  }
  const survey::SurveySummary s = survey::summary_of(survey);
  c.note(fmt::format(
      "survey {}: {} stations, measured depth {:.10g} to {:.10g} m, inclination up to {:.4g} deg (at "
      "{:.10g} m), dogleg up to {:.3g} deg/30 m (at {:.10g} m), azimuths from {} north",
      table.path, s.stations, s.first_md, s.last_md, s.largest_inclination / kDegree, s.largest_inclination_md,
      s.largest_severity * 30 / kDegree, s.largest_severity_md, north_name(conventions.azimuth_reference)));
}

void tell_readings(config::ConfigReader& c, const survey::SixAxisReadings& readings,
                   const survey::ReferenceField& field) {
  double gravity = 0, total = 0, sine = 0;
  for (std::size_t k = 0; k < readings.md.size(); ++k) {
    const double g = norm(readings.gravity_T[k]), b = norm(readings.magnetic_T[k]);
    gravity += g;
    total += b;
    sine += dot(readings.gravity_T[k], readings.magnetic_T[k]) / (g * b);
  }
  const double n = static_cast<double>(readings.md.size()), dip = std::asin(std::clamp(sine / n, -1.0, 1.0));
  c.note(
      fmt::format("readings {}: {} stations, measured depth {:.10g} to {:.10g} m, mean gravity {:.4f} m/s2, total "
                  "field {:.0f} nT, dip {:.2f} deg",
                  c.csv("readings").path, readings.md.size(), readings.md.front(), readings.md.back(), gravity / n,
                  total / n, dip / kDegree));
  const std::string key = c.has("field.model") ? "field.latitude_deg" : "field.dip_deg";
  constexpr double kClear = 5 * kDegree;  // nearer the magnetic equator the sign tells nothing
  constexpr double kFar = 10 * kDegree;   // biases of several thousand nT turn the mean field by less
  if (std::abs(dip) > kClear && std::abs(field.dip) > kClear && (dip > 0) != (field.dip > 0))
    c.warn(key,
           fmt::format(
               "the readings have a dip of {:+.2f} deg, the reference {:+.2f}: a wrong sign of dip (positive down, as "
               "in the north), or of the accelerometers (accelerometers = \"specific_force\" or \"gravity\")",
               dip / kDegree, field.dip / kDegree));
  else if (std::abs(dip - field.dip) > kFar)
    c.warn(key,
           fmt::format("the readings have a dip of {:+.2f} deg, the reference {:+.2f}: columns in another order, axes "
                       "of another sign, or the reference of another place?",
                       dip / kDegree, field.dip / kDegree));
}

}  // namespace surveymc::study
