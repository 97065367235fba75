#include "survey/survey_summary.h"

#include <cmath>

namespace surveymc::survey {

double dogleg(const Station& a, const Station& b) {
  const Vec3<double> ta = tangent_N({a.inclination, a.azimuth, 0}), tb = tangent_N({b.inclination, b.azimuth, 0});
  return 2 * std::atan2(norm(ta - tb), norm(ta + tb));
}

SurveySummary summary_of(const Survey& survey) {
  SurveySummary s;
  s.stations = survey.size();
  if (survey.stations.empty()) return s;
  s.first_md = s.largest_inclination_md = s.largest_severity_md = survey.stations.front().md;
  s.last_md = survey.stations.back().md;
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const Station& at = survey.stations[k];
    if (at.inclination > s.largest_inclination) {
      s.largest_inclination = at.inclination;
      s.largest_inclination_md = at.md;
    }
    if (k == 0) continue;
    const double severity = dogleg(survey.stations[k - 1], at) / (at.md - survey.stations[k - 1].md);
    if (severity > s.largest_severity) {
      s.largest_severity = severity;
      s.largest_severity_md = at.md;
    }
  }
  return s;
}

}  // namespace surveymc::survey
