#pragma once
/// The kernel behind station_draws.h, for both instruction sets (simd/lanes.h).
#include "sensor/station_draws.h"
#include "simd/instruction_set.h"

namespace surveymc::sensor {

struct StationDrawBatch {
  const StationTruth* stations;
  int count;          ///< of stations, at most kStationBatch
  int first_station;  ///< a multiple of kStationBatch
  StationDrawSd sd;
  random::Stream stream;
  std::uint64_t first_trial;
  int groups;
  double* readings;  ///< [group][station][row][lane]
};

SURVEYMC_KERNEL(void draw_station_batch(const StationDrawBatch& batch));

}  // namespace surveymc::sensor
