#include "proximity/well_path.h"

#include <algorithm>
#include <cmath>

#include "survey/minimum_curvature.h"

namespace surveymc::proximity {

using Eigen::Vector3d;

namespace {

constexpr double kStraight = 1e-12;  // rad: the arc is within 1e-12 of its length of the chord

}  // namespace

WellPath well_path(const survey::Survey& survey, const Vector3d& slot) {
  WellPath path;
  path.md_ = survey.md();
  path.positions_ = survey::minimum_curvature_positions(survey);
  for (Vector3d& p : path.positions_) p += slot;
  for (const survey::Station& s : survey.stations)
    path.tangents_.push_back(survey::to_eigen(survey::tangent_N({s.inclination, s.azimuth, 0})));
  for (std::size_t k = 0; k + 1 < path.md_.size(); ++k) {
    const Vector3d &t1 = path.tangents_[k], &t2 = path.tangents_[k + 1];
    WellPath::Leg leg;
    leg.length = path.md_[k + 1] - path.md_[k];
    // The half angle from chord and sum: exact to rounding from straight to nearly reversed.
    leg.dogleg = 2 * std::atan2((t2 - t1).norm(), (t2 + t1).norm());
    if (leg.dogleg > kStraight) {
      const Vector3d across = (t2 - t1) - t1 * t1.dot(t2 - t1);
      leg.normal = across.normalized();
    } else {
      leg.dogleg = 0;
    }
    path.legs_.push_back(leg);
  }
  return path;
}

PathPoint WellPath::at_station(std::size_t k) const {
  const bool is_last = k + 1 == md_.size();
  return {is_last ? k - 1 : k, is_last ? 1.0 : 0.0, md_[k], positions_[k], tangents_[k]};
}

PathPoint WellPath::at(double md) const {
  const auto after = std::upper_bound(md_.begin() + 1, md_.end() - 1, md);
  const auto leg = static_cast<std::size_t>(after - md_.begin()) - 1;
  return at(leg, std::clamp((md - md_[leg]) / legs_[leg].length, 0.0, 1.0));
}

PathPoint WellPath::at(std::size_t k, double share) const {
  const Leg& leg = legs_[k];
  if (share <= 0) return {k, 0.0, md_[k], positions_[k], tangents_[k]};
  if (share >= 1) return {k, 1.0, md_[k + 1], positions_[k + 1], tangents_[k + 1]};
  PathPoint p{k, share, md_[k] + share * leg.length, positions_[k], tangents_[k]};
  if (leg.dogleg == 0) {
    p.position += share * leg.length * tangents_[k];
    return p;
  }
  const double radius = leg.length / leg.dogleg, angle = share * leg.dogleg, half = std::sin(angle / 2);
  p.position += radius * (std::sin(angle) * tangents_[k] + 2 * half * half * leg.normal);
  p.tangent = std::cos(angle) * tangents_[k] + std::sin(angle) * leg.normal;
  return p;
}

ClosestPoint WellPath::closest_of_leg(const Vector3d& q, std::size_t k) const {
  const Leg& leg = legs_[k];
  const Vector3d d = q - positions_[k];
  const double along = d.dot(tangents_[k]);
  double share = along / leg.length;
  if (leg.dogleg != 0) share = std::atan2(along, leg.length / leg.dogleg - d.dot(leg.normal)) / leg.dogleg;
  ClosestPoint c{at(k, share)};
  c.distance = (c.point.position - q).norm();
  return c;
}

template <class Visit>
void WellPath::visit_minima(const Vector3d& q, std::size_t first, Visit visit) const {
  const auto end_point = [&](std::size_t k, PathEnd end) {
    visit(ClosestPoint{at_station(k), (positions_[k] - q).norm(), end});
  };
  double before = (positions_[first] - q).dot(tangents_[first]);
  if (before >= 0) end_point(first, PathEnd::start);
  for (std::size_t k = first + 1; k < md_.size(); ++k) {
    const double slope = (positions_[k] - q).dot(tangents_[k]);
    if (before < 0 && slope >= 0) visit(closest_of_leg(q, k - 1));
    before = slope;
  }
  if (before < 0) end_point(md_.size() - 1, PathEnd::end);
}

void WellPath::local_minima(const Vector3d& q, std::size_t first, std::vector<ClosestPoint>& out) const {
  out.clear();
  visit_minima(q, first, [&](const ClosestPoint& c) { out.push_back(c); });
}

ClosestPoint WellPath::closest(const Vector3d& q, std::size_t first) const {
  ClosestPoint best;
  best.distance = HUGE_VAL;
  visit_minima(q, first, [&](const ClosestPoint& c) {
    if (c.distance < best.distance) best = c;
  });
  return best;
}

}  // namespace surveymc::proximity
