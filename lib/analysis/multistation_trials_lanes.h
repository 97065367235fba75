#pragma once
/// The kernels behind multistation_trials.h, for both instruction sets (simd/lanes.h).
#include "multistation/parameters.h"
#include "random/stream.h"
#include "simd/instruction_set.h"

namespace surveymc::analysis {

/// Rows are kGroup doubles apart, groups `*_stride` doubles.
struct MultistationBatch {
  const double *gravity, *field;  ///< error-free, [3 station + axis]
  const double *tool, *tool_sd;   ///< [kParameters]
  double accelerometer, magnetometer;
  double gravity_reference, total, dip;  ///< true: m/s2, nT, rad
  double gravity_sd, total_sd, dip_sd;
  int stations, references;  ///< references: 1, or one a station
  random::Stream stream;
  std::uint64_t first_trial;
  int groups;
  double *gravity_out, *magnetic_out, *reference_out, *tools_out;
  std::size_t gravity_stride, magnetic_stride, reference_stride, tools_stride;
};

struct MultistationPositionBatch {
  const double *gravity, *magnetic, *md;
  std::size_t gravity_stride, magnetic_stride, position_stride;
  double* position;
  int stations, groups;
  double sin_declination, cos_declination;
};

SURVEYMC_KERNEL(void simulate_multistation_batch(const MultistationBatch& batch))
SURVEYMC_KERNEL(void multistation_position_batch(const MultistationPositionBatch& batch))

}  // namespace surveymc::analysis
