#include "sensor/station_draws.h"

#include <cassert>

#include "sensor/station_draws_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc::sensor {

survey::LaneArray draw_stations(const std::vector<StationTruth>& stations, int first_station, const StationDrawSd& sd,
                                const random::Stream& stream, std::uint64_t first_trial, int groups) {
  const int count = static_cast<int>(stations.size());
  assert(count <= kStationBatch && first_station % kStationBatch == 0);
  survey::LaneArray readings(groups, count * survey::kStationReadingRows);
  const StationDrawBatch b{stations.data(), count, first_station, sd, stream, first_trial, groups, readings.row(0, 0)};
  simd::run_kernel<isa_v3::draw_station_batch, isa_v4::draw_station_batch>(b);
  return readings;
}

}  // namespace surveymc::sensor
