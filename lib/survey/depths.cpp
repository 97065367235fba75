#include "survey/depths.h"

#include <algorithm>

namespace surveymc::survey {

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
