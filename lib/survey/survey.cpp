#include "survey/survey.h"

#include <algorithm>

#include "base/units.h"

namespace surveymc::survey {

std::vector<double> Survey::md() const {
  std::vector<double> depths;
  depths.reserve(stations.size());
  for (const Station& s : stations) depths.push_back(s.md);
  return depths;
}

std::vector<Vec3<double>> true_tangents(const Survey& survey) {
  std::vector<Vec3<double>> t;
  for (const Station& s : survey.stations) t.push_back(tangent_N({s.inclination, s.azimuth, 0}));
  return t;
}

SurveyDefect find_defect(const Survey& survey) {
  if (survey.size() < 2) return {-1, "stations", "a survey has at least two stations"};
  Vec3<double> tangent_before{};
  for (int k = 0; k < survey.size(); ++k) {
    const Station& s = survey.stations[static_cast<std::size_t>(k)];
    const Vec3<double> behind = tangent_before, tangent = tangent_N({s.inclination, s.azimuth, 0});
    tangent_before = tangent;
    if (!(s.inclination >= 0 && s.inclination <= kPi)) return {k, "inclination", "must be in [0, 180] degrees"};
    if (k == 0) continue;
    const Station& before = survey.stations[static_cast<std::size_t>(k - 1)];
    if (!(s.md > before.md)) return {k, "md", "must be greater than the one before"};
    if (is_same_depth(s.md, before.md))
      return {k, "md", "is within 1 mm of the one before: two stations at one depth are no leg"};
    // Minimum curvature has no answer for a reversal: the arc's plane is not defined there.
    const double c = dot(behind, tangent);
    if (!(c > -1 + 1e-12))
      return {k, "inclination",
              "the hole turns by 180 degrees from the station before, which leaves the plane of its arc open: correct "
              "it, or leave a "
              "station out"};
  }
  return {};
}

std::optional<std::size_t> station_at(const Survey& survey, double md) {
  const auto& s = survey.stations;
  const auto deeper = std::lower_bound(s.begin(), s.end(), md, [](const Station& a, double x) { return a.md < x; });
  auto nearest = deeper;
  if (nearest == s.end() || (nearest != s.begin() && md - (deeper - 1)->md < deeper->md - md)) --nearest;
  if (!is_same_depth(nearest->md, md)) return std::nullopt;
  return static_cast<std::size_t>(nearest - s.begin());
}

std::optional<double> depth_on(const Survey& survey, double md) {
  if (const auto k = station_at(survey, md)) return survey.stations[*k].md;
  if (md > survey.stations.front().md && md < survey.stations.back().md) return md;
  return std::nullopt;
}

}  // namespace surveymc::survey
