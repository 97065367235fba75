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

/// The same of a survey with a tie-on: readings are those of the `readings.stations` stations after the first.
struct TiedPositionBatch {
  CorrectedPositionBatch readings;  ///< md has one more station
  const double *tangents, *right;   ///< 3 numbers a station: of all stations; of the measured ones
  bool first_leg_doubled;
  double* lateral;
  std::size_t lateral_stride;
};
SURVEYMC_KERNEL(void tied_positions(const TiedPositionBatch& batch));

}  // namespace surveymc::survey
