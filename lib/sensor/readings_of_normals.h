#pragma once
/// Normals -> readings: the trials of simulate_readings and spread_tools as functions of their standard normals, for
/// methods that work on these (rare/limit_state.h).
#include <string>
#include <vector>

#include "sensor/magnetometer.h"
#include "sensor/tool_spread.h"
#include "survey/readings.h"

namespace surveymc::sensor {

/// Four neighbouring normals of the stream: indices 4 call .. 4 call + 3 of a channel.
struct NormalAddress {
  random::Channel channel{};
  std::uint32_t call = 0;
};

/// Meaning of the normals: rows first + index of an array of normals; -1: not drawn.
struct ReadingNormals {
  std::vector<NormalAddress> calls;  ///< rows 4 i .. 4 i + 3 are those of call i: where simulate_readings takes them
  int magnetometer = 0;              ///< 3 station + axis
  int accelerometer = -1;            ///< 3 station + axis
  int reference = -1;                ///< 2 station + {0 total field, 1 dip}; one pair where drawn once a run
  int tool = -1;                     ///< gain x, y, z, bias x, y, z
  int rows() const { return static_cast<int>(4 * calls.size()); }
};
ReadingNormals reading_normals(int stations, const NoiseModel& noise, const ToolSpread& spread);

/// "magnetometer_x", "accelerometer_z", "reference_total", "reference_dip", "tool_gain_x", "tool_bias_z" of every row;
/// "" where nothing is drawn.
std::vector<std::string> names_of(const ReadingNormals& normals, int stations);

/// Fills `out` with the readings of 8 `groups` trials whose normals are the rows of `z`. The law of the noise must
/// be Gaussian (asserted), and the trials not antithetic. With the normals of simulate_readings and spread_tools it
/// gives their readings, bit for bit.
void readings_of_normals(const CleanReadings& clean, const survey::ReferenceField& field, const NoiseModel& noise,
                         const ToolSpread& spread, const ReadingNormals& normals, const survey::LaneArray& z,
                         int groups, survey::ReadingBlock& out);

}  // namespace surveymc::sensor
