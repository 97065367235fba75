#include "proximity/drawn_pair.h"

#include <algorithm>
#include <numeric>

namespace surveymc::proximity {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using error_model::PropagationMode;
using propagate::WellErrors;
using propagate::WellPoint;

namespace {

/// Calls visit(source of the reference, source of the offset) for sources of one code and mode.
template <class Visit>
void visit_common(const WellErrors& reference, const WellErrors& offset, Visit visit) {
  for (const propagate::ErrorSource& r : reference.sources)
    for (const propagate::ErrorSource& o : offset.sources)
      if (r.code == o.code && r.mode == o.mode) visit(r, o);
}

std::uint32_t to_multiple_of_four(std::size_t n) { return static_cast<std::uint32_t>((n + 3) / 4 * 4); }

std::vector<std::size_t> by_depth(const std::vector<WellPoint>& points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(points[a].station, points[a].share) < std::pair(points[b].station, points[b].share);
  });
  return order;
}

std::vector<WellPoint> in_order(const std::vector<WellPoint>& points, const std::vector<std::size_t>& order) {
  std::vector<WellPoint> out;
  for (const std::size_t i : order) out.push_back(points[i]);
  return out;
}

}  // namespace

SharedDraws shared_draws(const WellErrors& reference, const WellErrors& offset, const PairErrors& pair) {
  SharedDraws out;
  for (const auto& [i, j] : pair.common.sources) {
    const JoiningSource& source = pair.reference->sources[i];
    visit_common(reference, offset, [&](const propagate::ErrorSource& r, const propagate::ErrorSource& o) {
      if (r.code == source.code && r.mode == source.mode && r.draws.size() == 1 && o.draws.size() == 1)
        out.emplace_back(r.draws.front(), o.draws.front());
    });
  }
  return out;
}

SharedDraws draws_of_shared_hole(const WellErrors& reference, const WellErrors& offset, std::size_t kickoff) {
  SharedDraws out;
  visit_common(reference, offset, [&](const propagate::ErrorSource& r, const propagate::ErrorSource& o) {
    if (error_model::joins_legs(r.mode) && r.draws.size() == 1 && o.draws.size() == 1) {
      out.emplace_back(r.draws.front(), o.draws.front());
      return;
    }
    for (const std::uint32_t i : r.draws)
      for (const std::uint32_t j : o.draws)
        if (reference.draws[i].first == offset.draws[j].first && reference.draws[i].first <= kickoff)
          out.emplace_back(i, j);
  });
  return out;
}

WellPoint well_point(const PathPoint& p) {
  if (p.share == 0 && p.leg > 0) return {p.leg, 1};
  return {p.leg + 1, p.share};
}

Matrix3d relative_covariance(const WellErrors& reference, const WellErrors& offset, const SharedDraws& shared,
                             const WellPoint& reference_point, const WellPoint& offset_point,
                             propagate::FirstOrder which) {
  const Eigen::Matrix3Xd r = propagate::draw_effects(reference, reference_point, which),
                         o = propagate::draw_effects(offset, offset_point, which);
  Matrix3d common = Matrix3d::Zero();
  for (const auto& [i, j] : shared) common += r.col(i) * o.col(j).transpose();
  return propagate::covariance_of(r) + propagate::covariance_of(o) - common - common.transpose();
}

std::vector<propagate::DrawPlace> offset_places(const WellErrors& reference, const WellErrors& offset,
                                                const SharedDraws& shared) {
  const std::vector<propagate::DrawPlace> of_reference = propagate::draw_places(reference);
  std::vector<propagate::DrawPlace> out =
      propagate::draw_places(offset, to_multiple_of_four(reference.station_draws),
                             to_multiple_of_four(reference.draws.size() - reference.station_draws));
  for (const auto& [i, j] : shared) out[j] = of_reference[i];
  return out;
}

DrawnPoints drawn_points(const WellErrors& errors, const std::vector<WellPoint>& points,
                         const std::vector<propagate::DrawPlace>& places) {
  const std::vector<std::size_t> order = by_depth(points);
  std::vector<std::size_t> position(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) position[order[i]] = i;
  return {std::move(position), propagate::drawn_well(errors, in_order(points, order), places, true)};
}

Vector3d DrawnPoints::error(const survey::LaneArray& out, int trial, std::size_t point) const {
  const int row = 3 * static_cast<int>(position_[point]);
  return {out.value(trial, row), out.value(trial, row + 1), out.value(trial, row + 2)};
}

Vector3d DrawnPoints::first_order(const survey::LaneArray& out, int trial, std::size_t point) const {
  const int row = 3 * static_cast<int>(position_.size() + position_[point]);
  return {out.value(trial, row), out.value(trial, row + 1), out.value(trial, row + 2)};
}

}  // namespace surveymc::proximity
