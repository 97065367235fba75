#pragma once
/// Readings of single stations: the truth of an attitude, and the noise, references and axial magnetisation of a trial.
#include <vector>

#include "random/stream.h"
#include "survey/frames.h"
#include "survey/station_readings.h"

namespace surveymc::sensor {

/// What one station reads and is told without any draw.
struct StationTruth {
  survey::Vec3<double> gravity_T;                              ///< m/s2
  survey::Vec3<double> magnetic_T;                             ///< nT, constant errors included
  double reference_gravity = 0, horizontal = 0, vertical = 0;  ///< references, their constant errors included
  double axial = 0;                                            ///< Mz that magnetic_T includes, nT
};

/// One standard deviation of each draw; 0: none.
struct StationDrawSd {
  double accelerometer_xy = 0, accelerometer_z = 0, magnetometer_xy = 0, magnetometer_z = 0;
  double gravity = 0, horizontal = 0, vertical = 0;
  double axial = 0;
};

/// Stations drawn in one go: first_station is a multiple of it.
inline constexpr int kStationBatch = 4;

/// Draws stations first_station .. first_station + stations.size() - 1 (at most kStationBatch of them) of the trials
/// first_trial .. first_trial + kGroup groups - 1. Rows as in survey/station_readings.h. Channels: accelerometer_noise,
/// magnetometer_noise, station_reference, axial_magnetisation, by station.
survey::LaneArray draw_stations(const std::vector<StationTruth>& stations, int first_station, const StationDrawSd& sd,
                                const random::Stream& stream, std::uint64_t first_trial, int groups);

}  // namespace surveymc::sensor
