#include "chained/side_by_side.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "base/units.h"
#include "chained/attitude.h"
#include "chained/descent_lanes.h"
#include "simd/instruction_set.h"
#include "survey/readings.h"

namespace surveymc::chained {
namespace {

constexpr int kLanes = simd::kGroup;
constexpr int kEndRows = 3;  // DescentOutcome

double squared(double x) { return x * x; }
double weight(double sd) { return 1 / squared(sd); }

std::vector<double> readings_of(const Readings& r) {
  std::vector<double> out;
  for (const StationReading& y : r.y) out.insert(out.end(), y.begin(), y.end());
  return out;
}

DescentModel descent_model(const Model& m, const std::vector<double>& readings, const std::vector<double>& weights) {
  DescentModel d{};
  d.gravity = m.gravity;
  d.horizontal = m.horizontal;
  d.down = m.down;
  for (std::size_t i = 0; i < kChainStates; ++i) {
    const bool anew = m.independent() && i < kReferenceStates;
    d.first[i] = weight(anew ? m.reference_sd[i] : m.prior_sd[i]);
    d.later[i] = anew ? d.first[i] : 0;
    d.link[i] = anew ? 0 : weight(m.link_sd[i]);
    d.scale[i] = weight(m.prior_sd[i]);
  }
  for (std::size_t i = 0; i < kChainStates; ++i)
    for (std::size_t j = 0; j <= i; ++j) d.links[simd::packed(i, j)] = d.link[i] * d.link[j];
  d.stations = static_cast<int>(readings.size() / 6);
  // cost_rounding(J) = b J + (its value at J = 0) sqrt(1 + J)
  d.rounding_of_cost = 4 * std::numeric_limits<double>::epsilon();
  d.per_rounding = cost_rounding(m, d.stations, 0);
  d.readings = readings.data();
  d.weights = weights.data();
  return d;
}

/// A value's place in the first row of six of a frame: n, then d.
void set_frame(double* row, const Eigen::Matrix3d& frame) {
  for (int i = 0; i < 3; ++i) {
    row[i * kLanes] = frame(i, 0);
    row[(3 + i) * kLanes] = frame(i, 2);
  }
}
Eigen::Matrix3d frame_at(const double* row) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i) {
    m(i, 0) = row[i * kLanes];
    m(i, 2) = row[(3 + i) * kLanes];
  }
  m.col(1) = m.col(2).cross(m.col(0));
  return m;
}

OffsetModel offset_model(const Model& m, const std::vector<double>& readings) {
  OffsetModel o{};
  o.gravity = m.gravity;
  o.horizontal = m.horizontal;
  o.down = m.down;
  o.stations = static_cast<int>(readings.size() / 6);
  const auto per_sd = [&](std::size_t reference, std::size_t reading) {
    return 1 / std::sqrt(squared(m.noise[reading]) + o.stations / 2.0 * squared(m.link_sd[kReferenceStates + reading]) +
                         squared(m.prior_sd[reference]));
  };
  o.per_sd[0] = per_sd(kGravityError, 2);
  o.per_sd[1] = per_sd(kHorizontalError, 5);
  o.per_sd[2] = per_sd(kDownError, 5);
  for (std::size_t i = 0; i < 6; ++i) o.offset_sd[i] = m.prior_sd[kReferenceStates + i];
  o.readings = readings.data();
  return o;
}

/// The searches' results are only starts for the descent of the chain: three digits are enough.
Options coarse_options(double step_tolerance) {
  Options o;
  o.step_tolerance = step_tolerance;
  o.gradient_tolerance = 1e-6;
  return o;
}

}  // namespace

std::vector<Ended> descend_all(const Model& model, const Readings& readings, const std::vector<Point>& starts,
                               const Options& options) {
  check(model);
  std::vector<Ended> ends;
  if (model.interference.states() > 0 || !readings.known.empty()) {
    for (const Point& start : starts) ends.push_back(descend_blocks(model, readings, start, options));
    return ends;
  }
  const int n = readings.stations(), groups = (static_cast<int>(starts.size()) + kLanes - 1) / kLanes;
  if (groups == 0) return ends;
  std::vector<double> y = readings_of(readings), w;
  for (int k = 0; k < n; ++k)
    for (std::size_t i = 0; i < 6; ++i) w.push_back(readings.used(k, i) ? weight(model.noise[i]) : 0);
  survey::LaneArray points(groups, kPointRows * n), outcome(groups, kEndRows),
      scratch(1, n * static_cast<int>(kDescentScratch / kLanes));
  for (int lane = 0; lane < groups * kLanes; ++lane) {
    // Lanes without a start of their own take the first one again
    const Point& start = starts[static_cast<std::size_t>(lane) < starts.size() ? static_cast<std::size_t>(lane) : 0];
    for (int k = 0; k < n; ++k) {
      double* row = points.row(lane / kLanes, kPointRows * k) + lane % kLanes;
      set_frame(row, start.frames[static_cast<std::size_t>(k)]);
      for (int i = 0; i < kChainStates; ++i) row[(6 + i) * kLanes] = start.chain[static_cast<std::size_t>(k)][i];
    }
  }
  const ChainDescentBatch batch{descent_model(model, y, w),
                                options,
                                points.row(0, 0),
                                points.group_stride(),
                                {outcome.row(0, 0), outcome.group_stride()},
                                groups,
                                scratch.row(0, 0)};
  simd::run_kernel<isa_v3::descend_chains, isa_v4::descend_chains>(batch);
  for (int lane = 0; lane < static_cast<int>(starts.size()); ++lane) {
    Ended e;
    for (int k = 0; k < n; ++k) {
      const double* row = points.row(lane / kLanes, kPointRows * k) + lane % kLanes;
      e.at.frames.push_back(frame_at(row));
      ChainVector c;
      for (int i = 0; i < kChainStates; ++i) c[i] = row[(6 + i) * kLanes];
      e.at.chain.push_back(c);
    }
    e.at.interference = Eigen::VectorXd(0);
    e.cost = outcome.value(lane, 0);
    e.iterations = static_cast<int>(outcome.value(lane, 1));
    e.status = static_cast<Status>(outcome.value(lane, 2));
    ends.push_back(std::move(e));
  }
  return ends;
}

Point search_attitudes(const Model& m, const Readings& readings) {
  const int n = readings.stations();
  std::vector<double> y = readings_of(readings), w;
  for (int k = 0; k < n; ++k)
    for (std::size_t i = 0; i < 6; ++i)
      w.push_back(1 / (squared(m.noise[i]) + squared(m.prior_sd[kReferenceStates + i])));
  survey::LaneArray frames(n, 6), outcome(n, kEndRows);
  for (int start = 0; start < kLanes; ++start) {
    const Eigen::Matrix3d from = frame_of({kPi / 4, (start % 4) * kPi / 2, (start / 4) * kPi});
    for (int k = 0; k < n; ++k) set_frame(frames.row(k, 0) + start, from);
  }
  const AttitudeDescentBatch batch{descent_model(m, y, w),
                                   coarse_options(1e-4),
                                   frames.row(0, 0),
                                   frames.group_stride(),
                                   {outcome.row(0, 0), outcome.group_stride()}};
  simd::run_kernel<isa_v3::descend_attitudes, isa_v4::descend_attitudes>(batch);
  Point p;
  for (int k = 0; k < n; ++k) {
    const double* cost = outcome.row(k, 0);
    p.frames.push_back(frame_at(frames.row(k, 0) + (std::min_element(cost, cost + kLanes) - cost)));
  }
  p.chain.assign(readings.y.size(), ChainVector::Zero());
  p.interference = Eigen::VectorXd::Zero(m.interference.states());
  return p;
}

double offset_misfit(const Model& m, const Readings& readings, const Offsets& offsets) {
  const std::vector<double> y = readings_of(readings);
  return OffsetDescent<double>(offset_model(m, y), offsets).cost();
}

std::vector<Offsets> search_offsets_from(const Model& m, const Readings& readings, const std::vector<Offsets>& starts) {
  const std::vector<double> y = readings_of(readings);
  std::vector<Offsets> ends;
  for (std::size_t first = 0; first < starts.size(); first += kLanes) {
    survey::LaneArray x(1, 6), outcome(1, kEndRows);
    const auto start = [&](int lane) -> const Offsets& {
      const std::size_t own = first + static_cast<std::size_t>(lane);
      return starts[own < starts.size() ? own : first];
    };
    for (int lane = 0; lane < kLanes; ++lane)
      for (int i = 0; i < 6; ++i) x.row(0, i)[lane] = start(lane)[static_cast<std::size_t>(i)];
    const OffsetDescentBatch batch{offset_model(m, y), coarse_options(1e-3), x.row(0, 0), {outcome.row(0, 0), 0}};
    simd::run_kernel<isa_v3::descend_offsets, isa_v4::descend_offsets>(batch);
    for (int lane = 0; lane < kLanes && first + static_cast<std::size_t>(lane) < starts.size(); ++lane) {
      Offsets end;
      for (int i = 0; i < 6; ++i) end[static_cast<std::size_t>(i)] = x.row(0, i)[lane];
      ends.push_back(end);
    }
  }
  return ends;
}

}  // namespace surveymc::chained
