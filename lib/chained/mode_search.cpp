#include "chained/mode_search.h"

#include <algorithm>
#include <cmath>

#include "chained/attitude.h"
#include "chained/basic_solution.h"

namespace surveymc::chained {

using Eigen::Vector3d;

namespace {

StationReading without(const Model& m, const StationReading& y, const Offsets& offsets) {
  StationReading r = y;
  for (std::size_t i = 0; i < 6; ++i) r[i] -= offsets[i] * m.prior_sd[kReferenceStates + i];
  return r;
}

Point point_with(const Model& m, const Readings& readings, const Offsets& offsets) {
  Point p;
  ChainVector c = ChainVector::Zero();
  for (std::size_t i = 0; i < 6; ++i)
    c[static_cast<Eigen::Index>(kReferenceStates + i)] = offsets[i] * m.prior_sd[kReferenceStates + i];
  for (const StationReading& y : readings.y) p.frames.push_back(basic_station(without(m, y, offsets)).frame);
  p.chain.assign(readings.y.size(), c);
  p.interference = Eigen::VectorXd::Zero(m.interference.states());
  return p;
}

Offsets offsets_of(const Model& m, const Point& p) {
  Offsets x;
  for (std::size_t i = 0; i < 6; ++i) {
    double mean = 0;
    for (const ChainVector& c : p.chain) mean += c[static_cast<Eigen::Index>(kReferenceStates + i)];
    x[i] = mean / static_cast<double>(p.chain.size()) / m.prior_sd[kReferenceStates + i];
  }
  return x;
}

Offsets mirrored_offsets(const Model& m, const Point& point) {
  double shift = 0;
  for (std::size_t k = 0; k < point.frames.size(); ++k) {
    // Bh cosA / sinI = Bh n_z / sin^2 I; where the hole is nearly vertical there is no second solution to look for
    const Vector3d d = point.frames[k].col(2);
    const double sine2 = std::max(d.x() * d.x() + d.y() * d.y(), 0.01);
    shift += 2 * (m.horizontal + point.chain[k][kHorizontalError]) * point.frames[k](2, 0) / sine2;
  }
  Offsets x = offsets_of(m, point);
  x[5] += shift / static_cast<double>(point.frames.size()) / m.prior_sd[kMagnetometerOffset + 2];
  return x;
}

bool same_mode(const Solution& a, const Ended& b) {
  double turn = 0;
  for (std::size_t k = 0; k < a.stations.size(); ++k)
    turn = std::max(turn, rotation_between(a.stations[k].frame, b.at.frames[k]).norm());
  return turn < 1e-6;  // minima after the descent are right to 1e-12
}

}  // namespace

Point search_offsets(const Model& m, const Readings& readings) {
  return point_with(m, readings, search_offsets_from(m, readings, {Offsets{}}).front());
}

Point mirrored(const Model& m, const Readings& readings, const Point& point, bool search) {
  const Offsets x = mirrored_offsets(m, point);
  return point_with(m, readings, search ? search_offsets_from(m, readings, {x}).front() : x);
}

std::vector<Point> search_starts(const Model& m, const Readings& readings, bool attitudes) {
  std::vector<Point> starts{basic_start(m, readings), search_offsets(m, readings)};
  const std::vector<Offsets> images{mirrored_offsets(m, starts[0]), mirrored_offsets(m, starts[1])};
  for (const Offsets& image : images) starts.push_back(point_with(m, readings, image));
  for (const Offsets& found : search_offsets_from(m, readings, images))
    starts.push_back(point_with(m, readings, found));
  if (attitudes) starts.push_back(search_attitudes(m, readings));
  return starts;
}

Modes find_modes(const Model& m, const Readings& readings, const SearchOptions& options) {
  check(m);
  return find_modes(m, readings, search_starts(m, readings, options.attitudes), options);
}

Modes find_modes(const Model& m, const Readings& readings, const std::vector<Point>& starts,
                 const SearchOptions& options) {
  return find_modes(m, readings, descend_all(m, readings, starts, options.polish), options);
}

Modes find_modes(const Model& m, const Readings& readings, const std::vector<Ended>& ends,
                 const SearchOptions& options) {
  Modes out;
  const auto add = [&](const Ended& e) {
    if (e.status != Status::converged) return;
    for (const Solution& known : out.modes)
      if (same_mode(known, e)) return;
    out.modes.push_back(solution_at(m, readings, e));
  };
  for (const Ended& e : ends) add(e);
  if (!out.modes.empty()) {  // the minimum's own mirror image
    std::sort(out.modes.begin(), out.modes.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
    add(descend_all(m, readings, {mirrored(m, readings, point_of(out.modes.front()), false)}, options.polish).front());
  }
  std::sort(out.modes.begin(), out.modes.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  out.ambiguous = out.modes.size() > 1 && out.modes[1].cost - out.modes[0].cost < options.ambiguity;
  return out;
}

}  // namespace surveymc::chained
