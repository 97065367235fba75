#include "sensor/station_draws.h"

#include <cassert>

#include "sensor/station_draws_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc {

LaneArray draw_stations(const std::vector<StationTruth>& stations, int first_station, const StationDrawSd& sd,
                        const Stream& stream, std::uint64_t first_trial, int groups) {
  const int count = static_cast<int>(stations.size());
  assert(count <= kStationBatch && first_station % kStationBatch == 0);
  LaneArray readings(groups, count * kStationReadingRows);
  const StationDrawBatch b{stations.data(), count, first_station, sd, stream, first_trial, groups, readings.row(0, 0)};
  if (instruction_set() == InstructionSet::v4)
    isa_v4::draw_station_batch(b);
  else
    isa_v3::draw_station_batch(b);
  return readings;
}

}  // namespace surveymc
