#include "chained/batch.h"

#include <cmath>
#include <memory>

#include <Eigen/Geometry>

#include "base/error.h"
#include "chained/smoother_lanes.h"
#include "chained/station_rows.h"
#include "simd/instruction_set.h"

namespace surveymc::chained {
namespace {

KernelModel kernel_model(const Model& m, int stations, const BatchOptions& options) {
  check(m);
  require(m.interference.states() == 0, "chained batch: interference: must be none");
  KernelModel k{};
  k.gravity = m.gravity;
  k.horizontal = m.horizontal;
  k.down = m.down;
  k.total = std::hypot(m.horizontal, m.down);
  for (std::size_t i = 0; i < 6; ++i) k.noise_variance[i] = m.noise[i] * m.noise[i];
  for (std::size_t i = 0; i < kChainStates; ++i) {
    const bool anew = m.independent() && i < kReferenceStates;
    const double first = anew ? m.reference_sd[i] : m.prior_sd[i], later = anew ? m.reference_sd[i] : m.link_sd[i];
    k.prior_variance[i] = first * first;
    k.link_variance[i] = later * later;
  }
  k.independent = m.independent();
  k.stations = stations;
  k.max_iterations = options.max_iterations;
  k.step_tolerance = options.step_tolerance;
  return k;
}

/// From rows of kGroup doubles; `row` is the first of a station, in a trial's lane.
StationEstimate estimate_of(const double* row) {
  const auto at = [&](int r) { return row[static_cast<std::size_t>(r) * simd::kGroup]; };
  StationEstimate s;
  for (int i = 0; i < 3; ++i) {
    s.frame(i, 0) = at(kRowNorth + i);
    s.frame(i, 2) = at(kRowDown + i);
  }
  s.frame.col(1) = s.frame.col(2).cross(s.frame.col(0));
  for (int i = 0; i < kChainStates; ++i) s.chain[i] = at(kRowChain + i);
  for (int i = 0, r = kRowCovariance; i < 12; ++i)
    for (int j = 0; j <= i; ++j, ++r) s.covariance(i, j) = s.covariance(j, i) = at(r);
  return s;
}

}  // namespace

BatchSolution::BatchSolution(int trials, int station_count)
    : stations(station_count),
      rows(survey::groups_for(trials), kStationRows * station_count),
      outcome(survey::groups_for(trials), 3) {}

StationEstimate BatchSolution::station(int trial, int k) const {
  return estimate_of(rows.row(trial / simd::kGroup, kStationRows * k) + trial % simd::kGroup);
}

Solution BatchSolution::solution(int trial) const {
  Solution s;
  s.converged = converged(trial);
  s.status = s.converged ? Status::converged : Status::iteration_limit;
  s.iterations = iterations(trial);
  s.cost = cost(trial);
  for (int k = 0; k < stations; ++k) s.stations.push_back(station(trial, k));
  return s;
}

void solve_batch(const Model& model, Mode mode, const Batch& in, BatchSolution& out, const BatchOptions& options) {
  survey::LaneArray scratch(1, in.stations * static_cast<int>(kScratch / simd::kGroup));
  LaneBatch b{kernel_model(model, in.stations, options),
              mode == Mode::filter,
              in.readings.row(0, 0),
              out.rows.row(0, 0),
              out.outcome.row(0, 0),
              in.readings.group_stride(),
              out.rows.group_stride(),
              out.outcome.group_stride(),
              survey::groups_for(in.trials),
              scratch.row(0, 0)};
  simd::run_kernel<isa_v3::solve_lane_batch, isa_v4::solve_lane_batch>(b);
}

Solution solve_alone(const Model& model, Mode mode, const std::vector<StationReading>& readings,
                     const BatchOptions& options) {
  const int n = static_cast<int>(readings.size());
  const KernelModel k = kernel_model(model, n, options);
  Batch one(1, n);
  for (int i = 0; i < n; ++i) one.set(0, i, readings[static_cast<std::size_t>(i)]);
  BatchSolution out(1, n);
  const auto store_station = [&](int station, const StationPoint<double>& at, const StationCovariance<double>& c) {
    store_station_rows<double>(out.rows.row(0, 0), station, at, c);
  };
  std::vector<StationMemory<double>> memory(readings.size());
  const Outcome<double> result = mode == Mode::filter
                                     ? filter_lanes<double>(k, one.readings.row(0, 0), store_station)
                                     : smooth_lanes<double>(k, one.readings.row(0, 0), memory.data(), store_station);
  out.outcome.row(0, 0)[0] = result.converged;
  out.outcome.row(0, 1)[0] = result.iterations;
  out.outcome.row(0, 2)[0] = result.cost;
  return out.solution(0);
}

}  // namespace surveymc::chained
