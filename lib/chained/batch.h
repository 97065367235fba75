#pragma once
/// Chained multistation for batches of trials, one trial a lane: >= 10,000 smoother runs of 18 stations a second and
/// core (docs/performance.md). The same answers as run_smoother and run_filter to rounding, from the basic
/// start.
#include "chained/model.h"
#include "survey/readings.h"

namespace surveymc::chained {

/// Readings of many trials: rows 6 k + axis of station k, as in StationReading.
struct Batch {
  Batch(int trial_count, int station_count)
      : trials(trial_count), stations(station_count), readings(survey::groups_for(trial_count), 6 * station_count) {}

  void set(int trial, int station, const StationReading& y) {
    for (int i = 0; i < 6; ++i)
      readings.row(trial / simd::kGroup, 6 * station + i)[trial % simd::kGroup] = y[static_cast<std::size_t>(i)];
  }

  int trials, stations;
  survey::LaneArray readings;
};

enum class Mode { smoother, filter };

/// Solutions of a batch, by undamped Gauss-Newton. A trial whose `converged` is false needs a damped solver:
/// solve_blocks for a smoother, run_filter for a filter.
class BatchSolution {
 public:
  BatchSolution(int trials, int stations);

  bool converged(int trial) const { return outcome.value(trial, 0) > 0; }
  int iterations(int trial) const { return static_cast<int>(outcome.value(trial, 1)); }
  double cost(int trial) const { return outcome.value(trial, 2); }
  StationEstimate station(int trial, int k) const;
  Solution solution(int trial) const;

  int stations;
  survey::LaneArray rows, outcome;
};

struct BatchOptions {
  int max_iterations = 30;
  double step_tolerance = 1e-9;  ///< as in Options
};

/// Throws InputError for an invalid model, or one with interference.
void solve_batch(const Model& model, Mode mode, const Batch& batch, BatchSolution& out,
                 const BatchOptions& options = {});

/// One trial by the same kernel in plain doubles, with which tests compare the lanes. Same bits.
Solution solve_alone(const Model& model, Mode mode, const std::vector<StationReading>& readings,
                     const BatchOptions& options = {});

}  // namespace surveymc::chained
