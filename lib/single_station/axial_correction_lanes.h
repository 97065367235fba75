#pragma once
/// The kernel behind solve_stations(), for both instruction sets (simd/lanes.h).
#include "simd/instruction_set.h"
#include "single_station/station_solution.h"

namespace surveymc::single_station {

struct StationSolveBatch {
  const double* readings;  ///< [group and station][row of station_readings.h][lane]
  double* solutions;       ///< [group and station][row of station_solution.h][lane]
  int count;               ///< groups times stations
  StationSigmas sigmas;
  StationMethod method;
};

SURVEYMC_KERNEL(void solve_station_batch(const StationSolveBatch& batch));

}  // namespace surveymc::single_station
