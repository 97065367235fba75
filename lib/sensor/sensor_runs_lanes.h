#pragma once
/// The kernels behind draw_runs and run_positions, for both instruction sets (simd/lanes.h).
#include <cstddef>
#include <cstdint>

#include "random/stream.h"
#include "simd/instruction_set.h"
#include "survey/position_method.h"
#include "survey/sensor_terms.h"
#include "survey/toolface_plan.h"

namespace surveymc::sensor {

/// Raw view of a batch; rows are kGroup doubles apart. A stride of 0 means one group shared by all.
struct SensorRunBatch {
  const double *gravity, *field;  ///< 3 stations
  const double* md;
  const survey::ToolfaceSource* source;
  const double *given_cos, *given_sin;  ///< stations
  int first_slid;                       ///< -1 without a slide
  int stations, groups;
  const int* reported;
  int reported_count;
  bool first_is_tie_on;
  survey::PositionMethod method;
  double sin_declination, cos_declination;
  survey::SensorTermArray sd;
  std::uint64_t first_trial;
  double *errors, *toolface, *positions;
  std::size_t errors_stride, toolface_stride, positions_stride;
};

SURVEYMC_KERNEL(void draw_sensor_runs(const SensorRunBatch& batch, const random::Stream& stream));
SURVEYMC_KERNEL(void sensor_run_positions(const SensorRunBatch& batch));

}  // namespace surveymc::sensor
