#include "survey/interpolated_survey.h"

#include <algorithm>
#include <cmath>

namespace surveymc::survey {
namespace {

/// Parts of an interval. A thousandth of a metre too much makes no further one.
double parts_of(double length, double spacing) { return std::max(1.0, std::ceil((length - kSameDepth) / spacing)); }

/// The direction at the share f of an interval.
Station station_between(const Station& from, const Station& to, double f) {
  Station s = to;
  s.md = from.md + f * (to.md - from.md);
  if (from.inclination == to.inclination && from.azimuth == to.azimuth) return s;
  const Vec3<double> t1 = tangent_N({from.inclination, from.azimuth, 0}),
                     t2 = tangent_N({to.inclination, to.azimuth, 0});
  const double dogleg = std::atan2(norm(cross(t1, t2)), dot(t1, t2));
  constexpr double kStraight = 1e-8;  // rad: the arc and the chord differ by its square
  const bool is_straight = dogleg < kStraight;
  const double w1 = is_straight ? 1 - f : std::sin((1 - f) * dogleg) / std::sin(dogleg),
               w2 = is_straight ? f : std::sin(f * dogleg) / std::sin(dogleg);
  const Vec3<double> t = scale(w1, t1) + scale(w2, t2);
  const double horizontal = std::hypot(t.x, t.y);
  s.inclination = std::atan2(horizontal, t.z);
  constexpr double kVertical = 1e-12;  // rounding alone has no azimuth
  if (horizontal > kVertical) s.azimuth = std::atan2(t.y, t.x);
  return s;
}

}  // namespace

InterpolatedSurvey interpolated(const Survey& survey, double spacing) {
  InterpolatedSurvey out;
  for (std::size_t k = 0; k < survey.stations.size(); ++k) {
    const Station& to = survey.stations[k];
    if (k > 0) {
      const Station& from = survey.stations[k - 1];
      const double parts = parts_of(to.md - from.md, spacing);
      for (double i = 1; i < parts; ++i) out.survey.stations.push_back(station_between(from, to, i / parts));
    }
    out.given.push_back(out.survey.stations.size());
    out.survey.stations.push_back(to);
  }
  return out;
}

double interpolated_stations(const Survey& survey, double spacing) {
  double count = 1;
  for (std::size_t k = 1; k < survey.stations.size(); ++k)
    count += parts_of(survey.stations[k].md - survey.stations[k - 1].md, spacing);
  return count;
}

double longest_interval(const Survey& survey) {
  double longest = 0;
  for (std::size_t k = 1; k < survey.stations.size(); ++k)
    longest = std::max(longest, survey.stations[k].md - survey.stations[k - 1].md);
  return longest;
}

std::vector<double> interpolated_values(const InterpolatedSurvey& dense, const std::vector<double>& given,
                                        const std::vector<double>& along) {
  std::vector<double> out(along.size());
  const auto md = [&](std::size_t i) { return dense.survey.stations[i].md; };
  for (std::size_t k = 0; k < given.size(); ++k) {
    const std::size_t to = dense.given[k];
    out[to] = given[k];
    if (k == 0) continue;
    const std::size_t from = dense.given[k - 1];
    const double miss = (given[k] - given[k - 1]) - (along[to] - along[from]);
    for (std::size_t i = from + 1; i < to; ++i)
      out[i] = given[k - 1] + (along[i] - along[from]) + miss * (md(i) - md(from)) / (md(to) - md(from));
  }
  return out;
}

}  // namespace surveymc::survey
