#include "survey/survey_summary.h"

#include <cmath>

namespace surveymc::survey {

namespace {

double angle_between(const Vec3<double>& ta, const Vec3<double>& tb) {
  return 2 * std::atan2(norm(ta - tb), norm(ta + tb));
}

Vec3<double> tangent_at(const Station& s) { return tangent_N({s.inclination, s.azimuth, 0}); }

}  // namespace

double dogleg(const Station& a, const Station& b) { return angle_between(tangent_at(a), tangent_at(b)); }

std::vector<double> doglegs(const Survey& survey) {
  std::vector<double> angles(survey.stations.size());
  Vec3<double> before{};
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const Vec3<double> at = tangent_at(survey.stations[k]);
    if (k > 0) angles[k] = angle_between(before, at);
    before = at;
  }
  return angles;
}

SurveySummary summary_of(const Survey& survey) {
  SurveySummary s;
  s.stations = survey.size();
  if (survey.stations.empty()) return s;
  s.first_md = s.largest_inclination_md = s.largest_severity_md = survey.stations.front().md;
  s.last_md = survey.stations.back().md;
  const std::vector<double> angles = doglegs(survey);
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const Station& at = survey.stations[k];
    if (at.inclination > s.largest_inclination) {
      s.largest_inclination = at.inclination;
      s.largest_inclination_md = at.md;
    }
    if (k == 0) continue;
    const double severity = angles[k] / (at.md - survey.stations[k - 1].md);
    if (severity > s.largest_severity) {
      s.largest_severity = severity;
      s.largest_severity_md = at.md;
    }
  }
  return s;
}

}  // namespace surveymc::survey
