#pragma once
/// What differs from run to run beside the noise of readings and reference.
#include <cmath>
#include <cstdint>

#include "random/stream.h"
#include "sensor/magnetometer.h"
#include "survey/readings.h"

namespace surveymc::sensor {

/// Every run has a tool of its own: true gains and biases are Gaussian about the nominal ones, one standard deviation
/// per axis.
struct ToolSpread {
  double gain = 0;        ///< 1
  double bias = 0;        ///< nT
  double axial_bias = 0;  ///< nT, bias z has this too: interference of the drill string
  bool any() const { return gain > 0 || bias > 0 || axial_bias > 0; }
  /// Of gain x, y, z (1), bias x, y, z (nT).
  double sd(std::size_t parameter) const {
    return parameter < 3 ? gain : parameter < 5 ? bias : std::hypot(bias, axial_bias);
  }
};

/// Adds d gain_i b_i + d bias_i of every trial to the readings of simulate_readings, and writes the deviations (rows:
/// gain x, y, z; bias x, y, z in nT) to `deviation`. If `sums` is given, it adds weights.tool times the draws to them.
/// The same addresses as simulate_readings (`antithetic` as in its NoiseModel); first_trial is a multiple of kGroup.
void spread_tools(const CleanReadings& clean, const ToolSpread& spread, bool antithetic, const random::Stream& stream,
                  std::uint64_t first_trial, survey::ReadingBlock& readings, survey::LaneArray& deviation,
                  const NoiseWeights* weights = nullptr, survey::LaneArray* sums = nullptr);

/// How the sd that a weighted estimator assumes of a reading is drawn anew in each run (thesis section 2.2: "random
/// noise between 0 and 70 nT on the diagonal").
enum class AssumedNoise {
  constant,         ///< not at all
  random_sd,        ///< sd = U(0, size) nT
  random_variance,  ///< variance = U(0, size) nT^2, the words as they stand
};

/// Fills readings.assumed_sd (which must have room); `size` in nT.
void draw_assumed_sd(AssumedNoise law, double size, const random::Stream& stream, std::uint64_t first_trial,
                     survey::ReadingBlock& readings);

}  // namespace surveymc::sensor
