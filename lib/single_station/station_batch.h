#pragma once
/// station_solution.h for many trials at once.
#include "single_station/station_solution.h"
#include "survey/station_readings.h"

namespace surveymc::single_station {

/// Rows of a solution; station k of a batch starts at row k kStationSolutionRows.
inline constexpr int kAxesRow = 0;    ///< sin, cos of the inclination, sin, cos of the toolface
inline constexpr int kTotalRow = 4;   ///< gravity, m/s2
inline constexpr int kNorthRow = 5;   ///< Bh cosA, Bh sinA, Bd, Mz, nT
inline constexpr int kCostRow = 9;    ///< see StationSolution
inline constexpr int kFoundRow = 10;  ///< 1, or 0 where the method gives no answer
inline constexpr int kStationSolutionRows = 11;

/// Solves all stations of a block by one method: lane i of the result is bit for bit solve_station() of trial i.
/// Throws InputError like check_sigmas.
survey::LaneArray solve_stations(const survey::LaneArray& readings, int stations, int groups,
                                 const StationSigmas& sigmas, StationMethod method);

}  // namespace surveymc::single_station
