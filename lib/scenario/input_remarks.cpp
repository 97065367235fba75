#include "scenario/input_remarks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "base/error.h"
#include "base/units.h"
#include "config/meanings.h"
#include "config/survey_checks.h"
#include "survey/survey_summary.h"

namespace surveymc::scenario {

const char* north_name(config::AzimuthReference north) {
  return north == config::AzimuthReference::magnetic ? "magnetic"
         : north == config::AzimuthReference::grid   ? "grid"
                                                     : "true";
}

void remark_on_survey(config::ConfigReader& c, const config::InputTable& table, const survey::Survey& survey,
                      const config::SurveyConventions& conventions, const std::string& unusual) {
  // The key is asked for by has() first, so that no default of it is written into every config.
  const bool allowed = c.has(unusual) && c.choice(unusual, {"refuse", "allow"}, config::meaning::kUnusual) == "allow";
  for (const config::SurveyFinding& f : config::unusual_in_survey(table, survey)) {
    if (f.is_refused && !allowed)
      throw InputError(fmt::format("{}; if the survey is meant so, set {} = \"allow\"", f.in_words(), unusual));
    c.warn_at(f.place, f.value, f.text, f.way_out);
  }
  const survey::SurveySummary s = survey::summary_of(survey);
  c.note(fmt::format(
      "survey {}: {} stations, measured depth {:.10g} to {:.10g} m, inclination up to {:.4g} deg (at "
      "{:.10g} m), dogleg up to {:.3g} deg/30 m (at {:.10g} m), azimuths from {} north",
      table.path, s.stations, s.first_md, s.last_md, s.largest_inclination / kDegree, s.largest_inclination_md,
      s.largest_severity * 30 / kDegree, s.largest_severity_md, north_name(conventions.azimuth_reference)));
}

namespace {

using Axis = double survey::Vec3<double>::*;

/// The direction of the tool's axis `a` in the frame of magnetic north, east and down.
survey::Vec3<double> direction_of(const survey::SixAxisReadings& r, std::size_t k, Axis a) {
  const survey::Vec3<double>&g = r.gravity_T[k], &b = r.magnetic_T[k];
  const survey::Vec3<double> east = cross(g, b), north = cross(east, g);
  return {north.*a / norm(north), east.*a / norm(east), g.*a / norm(g)};
}

struct Turning {
  double angle = 0, length = 1;  ///< of the sharpest turn
  std::size_t station = 0, others = 0;
};

/// Turns between neighbours that no tool drills, if `axis` is the one down-hole.
Turning undrilled_turns(const survey::SixAxisReadings& r, Axis axis) {
  constexpr double kDrillable = 30 * kDegree / 30, kLeast = 3 * kDegree;  // rad/m; readings have noise
  Turning worst;
  for (std::size_t k = 1; k < r.md.size(); ++k) {
    const survey::Vec3<double> a = direction_of(r, k - 1, axis), b = direction_of(r, k, axis);
    const double angle = std::atan2(norm(cross(a, b)), dot(a, b)), length = r.md[k] - r.md[k - 1];
    if (!(angle > kLeast && angle > kDrillable * length)) continue;
    ++worst.others;
    if (angle / length > worst.angle / worst.length) worst = {angle, length, k, worst.others};
  }
  return worst;
}

/// z is down-hole (docs/conventions.md). Where another axis is, a tool that rotates seems to turn the hole.
void warn_of_axes(config::ConfigReader& c, const survey::SixAxisReadings& r) {
  const Turning z = undrilled_turns(r, &survey::Vec3<double>::z);
  if (z.others == 0) return;
  const std::string place = "readings " + c.csv("readings", config::kMeaningElsewhere).path;
  std::string way_out;
  for (const auto& [name, axis] : {std::pair{"x", &survey::Vec3<double>::x}, std::pair{"y", &survey::Vec3<double>::y}})
    if (undrilled_turns(r, axis).others == 0)
      way_out += fmt::format("{}the {} axis turns as a hole does: is it the one down-hole? It must be z",
                             way_out.empty() ? "" : "; ", name);
  c.warn_at(
      place, "",
      fmt::format("between {:.10g} and {:.10g} m their z axis turns by {:.4g} deg{}: no tool drills more than 30 "
                  "deg/30 m",
                  r.md[z.station - 1], r.md[z.station], z.angle / kDegree,
                  z.others > 1 ? fmt::format(" (and in {} other places by more than is drilled)", z.others - 1) : ""),
      way_out);
}

}  // namespace

void remark_on_readings(config::ConfigReader& c, const survey::SixAxisReadings& readings,
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
                  c.csv("readings", config::kMeaningElsewhere).path, readings.md.size(), readings.md.front(),
                  readings.md.back(), gravity / n, total / n, dip / kDegree));
  warn_of_axes(c, readings);
  const std::string key = c.has("field.model") ? "field.latitude_deg" : "field.dip_deg";
  constexpr double kClear = 5 * kDegree;  // nearer the magnetic equator the sign tells nothing
  constexpr double kFar = 10 * kDegree;   // biases of several thousand nT turn the mean field by less
  if (std::abs(dip) > kClear && std::abs(field.dip) > kClear && (dip > 0) != (field.dip > 0))
    c.warn(key,
           fmt::format("the readings have a dip of {:+.2f} deg, the reference {:+.2f}", dip / kDegree,
                       field.dip / kDegree),
           "a wrong sign of dip (positive down, as in the north), or of the accelerometers (accelerometers = "
           "\"specific_force\" or \"gravity\")?");
  else if (std::abs(dip - field.dip) > kFar)
    c.warn(key,
           fmt::format("the readings have a dip of {:+.2f} deg, the reference {:+.2f}", dip / kDegree,
                       field.dip / kDegree),
           "columns in another order, axes of another sign, or the reference of another place?");
}

}  // namespace surveymc::scenario
