#pragma once
/// The kernel behind corrected_final_positions, for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "simd/instruction_set.h"
#include "simd/lanes.h"

namespace surveymc::survey {

/// Raw view of a batch: group g begins at `magnetic + g * magnetic_stride`, and so on; rows are kGroup doubles apart.
struct CorrectedPositionBatch {
  const double *magnetic, *down, *parameters;
  std::size_t magnetic_stride, down_stride, parameters_stride;
  double* position;
  std::size_t position_stride;
  const double* md;  ///< stations
  int stations, groups;
  double sin_declination, cos_declination;
};

SURVEYMC_KERNEL(void corrected_positions(const CorrectedPositionBatch& batch));

}  // namespace surveymc::survey
