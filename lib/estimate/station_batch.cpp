#include "estimate/station_batch.h"

#include "estimate/axial_correction_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc {

LaneArray solve_stations(const LaneArray& readings, int stations, int groups, const StationSigmas& sigmas,
                         StationMethod method) {
  check_sigmas(sigmas, method);
  LaneArray solutions(groups, stations * kStationSolutionRows);
  const StationSolveBatch b{readings.row(0, 0), solutions.row(0, 0), groups * stations, sigmas, method};
  if (instruction_set() == InstructionSet::v4)
    isa_v4::solve_station_batch(b);
  else
    isa_v3::solve_station_batch(b);
  return solutions;
}

}  // namespace surveymc
