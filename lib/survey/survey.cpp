#include "survey/survey.h"

#include "base/units.h"

namespace surveymc::survey {

Attitude attitude_from_fields(const Vec3<double>& g_T, const Vec3<double>& b_T) {
  const double cross_axis = std::hypot(g_T.x, g_T.y);
  Attitude at;
  at.inclination = std::atan2(cross_axis, g_T.z);
  if (cross_axis > 0) at.toolface = std::atan2(-g_T.x, -g_T.y);
  // From b_T's three rows (head of frames.h): well determined in a vertical hole too, where toolface is anything.
  const double st = std::sin(at.toolface), ct = std::cos(at.toolface);
  at.azimuth = std::atan2(b_T.x * ct - b_T.y * st,
                          std::cos(at.inclination) * (b_T.x * st + b_T.y * ct) + std::sin(at.inclination) * b_T.z);
  if (at.azimuth < 0) at.azimuth += 2 * kPi;
  if (at.toolface < 0) at.toolface += 2 * kPi;
  return at;
}

std::vector<double> Survey::md() const {
  std::vector<double> depths;
  depths.reserve(stations.size());
  for (const Station& s : stations) depths.push_back(s.md);
  return depths;
}

SurveyDefect find_defect(const Survey& survey) {
  if (survey.size() < 2) return {-1, "stations", "a survey has at least two stations"};
  for (int k = 0; k < survey.size(); ++k) {
    const Station& s = survey.stations[static_cast<std::size_t>(k)];
    if (!(s.inclination >= 0 && s.inclination <= kPi)) return {k, "inclination", "must be in [0, 180] degrees"};
    if (k == 0) continue;
    const Station& before = survey.stations[static_cast<std::size_t>(k - 1)];
    if (!(s.md > before.md)) return {k, "md", "must be greater than the one before"};
    // Minimum curvature has no answer for a reversal: the arc's plane is not defined there.
    const double c = dot(tangent_N({before.inclination, before.azimuth, 0}), tangent_N({s.inclination, s.azimuth, 0}));
    if (!(c > -1 + 1e-12)) return {k, "inclination", "the hole turns by 180 degrees from the station before"};
  }
  return {};
}

}  // namespace surveymc::survey
