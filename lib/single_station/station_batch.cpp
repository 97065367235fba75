#include "single_station/station_batch.h"

#include "simd/instruction_set.h"
#include "single_station/axial_correction_lanes.h"

namespace surveymc::single_station {

survey::LaneArray solve_stations(const survey::LaneArray& readings, int stations, int groups,
                                 const StationSigmas& sigmas, StationMethod method) {
  check_sigmas(sigmas, method);
  survey::LaneArray solutions(groups, stations * kStationSolutionRows);
  const StationSolveBatch b{readings.row(0, 0), solutions.row(0, 0), groups * stations, sigmas, method};
  simd::run_kernel<isa_v3::solve_station_batch, isa_v4::solve_station_batch>(b);
  return solutions;
}

}  // namespace surveymc::single_station
