#pragma once
/// Runs of a tool whose offsets, and whose references' errors, walk from station to station (ISCWSA slides, "Testing
/// Model"): truth and readings of one trial.
#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "random/stream.h"
#include "survey/frames.h"

namespace surveymc::sensor {

/// All inputs of a run except the random draws; sizes are one standard deviation. States: errors of gravity (m/s2),
/// horizontal and downward field (nT), offsets of accelerometers (m/s2) and magnetometers (nT) x, y, z.
struct ChainedRunSetup {
  double gravity = 9.80665, horizontal = 0, down = 0;  ///< references: m/s2, nT, nT
  std::array<double, 9> first_sd{}, step_sd{};
  std::array<double, 6> noise{};            ///< of readings: m/s2, nT
  std::vector<survey::Attitude> attitudes;  ///< azimuth magnetic
  bool random_toolface = true;              ///< uniform at every station instead of the attitudes' own
  std::array<double, 9> constant_state{};   ///< added to the states of all stations
  /// Interference at station k: (1 + rate k)^-2 times this vector in N-E-V, nT.
  survey::Vec3<double> interference{0, 0, 0};
  double interference_rate = 0.35;
};

struct ChainedRun {
  std::vector<survey::Attitude> attitudes;      ///< as drawn
  std::vector<Eigen::Matrix3d> frames;          ///< columns: north, east, down in the tool frame
  std::vector<std::array<double, 9>> states;    ///< the truth
  std::vector<std::array<double, 6>> readings;  ///< specific force (which points up) x, y, z, field x, y, z
};

/// Draws of a run, for every station.
struct ChainedDraws {
  std::vector<std::array<double, 9>> steps;  ///< standard normals: first values and steps of the states
  std::vector<std::array<double, 6>> noise;  ///< standard normals
  std::vector<double> toolface;              ///< in (0, 1); needed where toolfaces are random
};
ChainedDraws draw_chained_run(const ChainedRunSetup& setup, const random::Stream& stream, std::uint64_t trial);
ChainedRun chained_run_of(const ChainedRunSetup& setup, const ChainedDraws& draws);

/// chained_run_of() of draw_chained_run().
ChainedRun simulate_chained_run(const ChainedRunSetup& setup, const random::Stream& stream, std::uint64_t trial);

}  // namespace surveymc::sensor
