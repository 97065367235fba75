#pragma once
/// The kernel behind batch.h, for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "chained/chain_kernel.h"
#include "simd/instruction_set.h"
#include "simd/lanes.h"

namespace surveymc::chained {

/// Raw view of a batch; rows are kGroup doubles apart. Output rows are those of station_rows.h.
struct LaneBatch {
  KernelModel model;
  bool filter;
  const double* readings;
  double *stations, *outcome;
  std::size_t readings_stride, stations_stride, outcome_stride;  ///< from a group to the next
  int groups;
  double* scratch;  ///< kScratch (station_rows.h) doubles a station, aligned to 64 bytes
};

SURVEYMC_KERNEL(void solve_lane_batch(const LaneBatch& batch));

}  // namespace surveymc::chained
