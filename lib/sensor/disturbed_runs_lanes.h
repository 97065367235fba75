#pragma once
/// The kernels behind draw_disturbed_runs and disturbed_readings, for both instruction sets (simd/lanes.h).
#include <cstddef>
#include <cstdint>

#include "sensor/disturbed_runs.h"
#include "simd/instruction_set.h"

namespace surveymc::sensor {

/// Raw view of a batch; rows are kGroup doubles apart.
struct DisturbedRunBatch {
  const double* frames;
  int stations, groups;
  survey::SensorTermArray sd;
  double interference, noise, total, dip, gravity;
  ReferenceErrors run, station;
  const double* mixing;  ///< rows of draw_mixing(); null: all errors are normal
  std::size_t mixing_stride;
  const std::int32_t* slot_of;  ///< of DisturbedRunSetup
  bool turned;
  std::uint64_t first_trial;
  double *magnetic, *down, *reference;
  std::size_t magnetic_stride, down_stride, reference_stride;
  const double* made;  ///< draws of the stations; null: the stream's
  std::size_t made_stride;
  double* gravity_size;  ///< may be null
  std::size_t gravity_size_stride;
};

SURVEYMC_KERNEL(void disturbed_runs(const DisturbedRunBatch& batch, const random::Stream& stream));
SURVEYMC_KERNEL(void disturbed_readings(const DisturbedRunBatch& batch, const double* z, std::size_t stride));

}  // namespace surveymc::sensor
