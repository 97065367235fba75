#pragma once
/// Chained multistation for batches of trials, one trial a lane: >= 10,000 smoother runs of 18 stations a second and
/// core (docs/performance.md). The same answers as smooth_chained and filter_chained to rounding, from the basic start.
#include "estimate/chained_model.h"
#include "survey/readings.h"

namespace surveymc {

/// Readings of many trials: rows 6 k + axis of station k, as in StationReading.
struct ChainedBatch {
  ChainedBatch(int trial_count, int station_count)
      : trials(trial_count), stations(station_count), readings(groups_for(trial_count), 6 * station_count) {}

  void set(int trial, int station, const StationReading& y) {
    for (int i = 0; i < 6; ++i)
      readings.row(trial / kGroup, 6 * station + i)[trial % kGroup] = y[static_cast<std::size_t>(i)];
  }

  int trials, stations;
  LaneArray readings;
};

enum class ChainedMode { smoother, filter };

/// Answers of a batch, by undamped Gauss-Newton. Where `converged` is false the trial needs what is damped:
/// solve_chained for a smoother, filter_chained for a filter.
class ChainedBatchSolution {
 public:
  ChainedBatchSolution(int trials, int stations);

  bool converged(int trial) const { return outcome.value(trial, 0) > 0; }
  int iterations(int trial) const { return static_cast<int>(outcome.value(trial, 1)); }
  double cost(int trial) const { return outcome.value(trial, 2); }
  StationEstimate station(int trial, int k) const;
  ChainedSolution solution(int trial) const;

  int stations;
  LaneArray rows, outcome;
};

struct ChainedBatchOptions {
  int max_iterations = 30;
  double step_tolerance = 1e-9;  ///< as in ChainedOptions
};

/// Throws InputError for an invalid model, or one with interference.
void solve_chained_batch(const ChainedModel& model, ChainedMode mode, const ChainedBatch& batch,
                         ChainedBatchSolution& out, const ChainedBatchOptions& options = {});

/// One trial by the same kernel in plain doubles: the readable oracle of the lanes. Same bits.
ChainedSolution solve_chained_alone(const ChainedModel& model, ChainedMode mode,
                                    const std::vector<StationReading>& readings,
                                    const ChainedBatchOptions& options = {});

}  // namespace surveymc
