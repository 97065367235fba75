#include "estimate/chained_batch.h"

#include <cmath>
#include <memory>

#include <Eigen/Geometry>

#include "base/error.h"
#include "estimate/chained_lanes.h"
#include "estimate/chained_rows.h"
#include "simd/instruction_set.h"

namespace surveymc {
namespace {

ChainedKernelModel kernel_model(const ChainedModel& m, int stations, const ChainedBatchOptions& options) {
  check(m);
  require(m.interference.states() == 0, "chained batch: interference: must be none");
  ChainedKernelModel k{};
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
  const auto at = [&](int r) { return row[static_cast<std::size_t>(r) * kGroup]; };
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

ChainedBatchSolution::ChainedBatchSolution(int trials, int station_count)
    : stations(station_count), rows(groups_for(trials), kStationRows * station_count), outcome(groups_for(trials), 3) {}

StationEstimate ChainedBatchSolution::station(int trial, int k) const {
  return estimate_of(rows.row(trial / kGroup, kStationRows * k) + trial % kGroup);
}

ChainedSolution ChainedBatchSolution::solution(int trial) const {
  ChainedSolution s;
  s.converged = converged(trial);
  s.status = s.converged ? ChainedStatus::converged : ChainedStatus::iteration_limit;
  s.iterations = iterations(trial);
  s.cost = cost(trial);
  for (int k = 0; k < stations; ++k) s.stations.push_back(station(trial, k));
  return s;
}

void solve_chained_batch(const ChainedModel& model, ChainedMode mode, const ChainedBatch& in, ChainedBatchSolution& out,
                         const ChainedBatchOptions& options) {
  LaneArray scratch(1, in.stations * static_cast<int>(kChainedScratch / kGroup));
  ChainedLaneBatch b{kernel_model(model, in.stations, options),
                     mode == ChainedMode::filter,
                     in.readings.row(0, 0),
                     out.rows.row(0, 0),
                     out.outcome.row(0, 0),
                     in.readings.group_stride(),
                     out.rows.group_stride(),
                     out.outcome.group_stride(),
                     groups_for(in.trials),
                     scratch.row(0, 0)};
  if (instruction_set() == InstructionSet::v4)
    isa_v4::chained_batch(b);
  else
    isa_v3::chained_batch(b);
}

ChainedSolution solve_chained_alone(const ChainedModel& model, ChainedMode mode,
                                    const std::vector<StationReading>& readings, const ChainedBatchOptions& options) {
  const int n = static_cast<int>(readings.size());
  const ChainedKernelModel k = kernel_model(model, n, options);
  ChainedBatch one(1, n);
  for (int i = 0; i < n; ++i) one.set(0, i, readings[static_cast<std::size_t>(i)]);
  ChainedBatchSolution out(1, n);
  const auto store_station = [&](int station, const ChainedStation<double>& at, const StationCovariance<double>& c) {
    store_station_rows<double>(out.rows.row(0, 0), station, at, c);
  };
  std::vector<ChainedMemory<double>> memory(readings.size());
  const ChainedOutcome<double> result =
      mode == ChainedMode::filter ? chained_filter<double>(k, one.readings.row(0, 0), store_station)
                                  : chained_smooth<double>(k, one.readings.row(0, 0), memory.data(), store_station);
  out.outcome.row(0, 0)[0] = result.converged;
  out.outcome.row(0, 1)[0] = result.iterations;
  out.outcome.row(0, 2)[0] = result.cost;
  return out.solution(0);
}

}  // namespace surveymc
