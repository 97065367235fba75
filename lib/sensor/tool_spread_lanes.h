#pragma once
/// The kernels behind tool_spread.h, for both instruction sets (simd/lanes.h).
#include <cstddef>
#include <cstdint>

#include "sensor/tool_spread.h"
#include "simd/instruction_set.h"

namespace surveymc::sensor {

/// Raw view of a batch; rows are kGroup doubles apart.
struct ToolSpreadBatch {
  const double* field;                  ///< 3 stations: true field in the tool frame
  double *magnetic, *deviation, *sums;  ///< sums null when none are wanted
  const double* weights;                ///< [6][NoiseWeights::kSums]
  std::size_t magnetic_stride, deviation_stride, sums_stride;
  int stations, groups;
  std::uint64_t first_trial;
  double sd[6];  ///< of gain x, y, z (1), bias x, y, z (nT)
  bool antithetic;
  random::Stream stream;
};

struct AssumedSdBatch {
  double* assumed_sd;
  std::size_t stride;
  int rows, groups;
  std::uint64_t first_trial;
  AssumedNoise law;
  double size;
  random::Stream stream;
};

SURVEYMC_KERNEL(void spread_tools(const ToolSpreadBatch& batch));
SURVEYMC_KERNEL(void draw_assumed_sd(const AssumedSdBatch& batch));

}  // namespace surveymc::sensor
