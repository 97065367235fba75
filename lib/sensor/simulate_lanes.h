#pragma once
/// The kernel behind simulate_readings, for both instruction sets (simd/lanes.h).
#include <cstddef>
#include <cstdint>

#include "random/stream.h"
#include "sensor/magnetometer.h"
#include "simd/instruction_set.h"

namespace surveymc::sensor {

/// Raw view of readings without noise and of a block to fill; rows are kGroup doubles apart. A stride of 0 means one
/// group shared by all.
struct ReadingRows {
  const double *clean_magnetic, *clean_gravity, *clean_down, *clean_field;  ///< 3 stations
  double *magnetic, *down, *reference;
  std::size_t magnetic_stride, down_stride, reference_stride;
  int stations, reference_pairs;
  double total, dip;  ///< reference without error, nT and rad
};
ReadingRows reading_rows(const CleanReadings& clean, const survey::ReferenceField& field, survey::ReadingBlock& out);

/// A batch of trials whose noise is drawn.
struct SimulateBatch {
  ReadingRows rows;
  int groups;
  std::uint64_t first_trial;
  NoiseModel noise;
  random::Stream stream;
  /// Weights of NoiseWeights, or null; `sums` is null when no sums are wanted.
  const double *magnetometer_weights, *accelerometer_weights, *reference_weights;
  double* sums;
  std::size_t sums_stride;
  const double* mixing;  ///< rows of draw_mixing(); null: the reference is normal
  std::size_t mixing_stride;
  const std::int32_t* slot_of;  ///< of ReferenceMixing
  const double* made;           ///< draws of the reference, rows 2 station + {total field, dip}; null: the stream's
  std::size_t made_stride;
};

/// The same of normals that are given: rows of `z` from which each source is read; null: not drawn.
struct GivenNormalsBatch {
  ReadingRows rows;
  int groups;
  double magnetometer_sd, accelerometer_sd, total_sd, dip_sd;
  const double *magnetometer_z, *accelerometer_z, *reference_z, *tool_z;
  std::size_t z_stride;
  double tool_sd[6];  ///< gain x, y, z; bias x, y, z
};

SURVEYMC_KERNEL(void simulate(const SimulateBatch& batch));
SURVEYMC_KERNEL(void readings_of_normals(const GivenNormalsBatch& batch));

}  // namespace surveymc::sensor
