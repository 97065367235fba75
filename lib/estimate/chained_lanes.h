#pragma once
/// The kernel behind chained_batch.h, for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "estimate/chained_kernel.h"
#include "simd/lanes.h"

namespace surveymc {

/// Raw view of a batch; rows are kGroup doubles apart. Output rows are those of chained_batch.h.
struct ChainedLaneBatch {
  ChainedKernelModel model;
  bool filter;
  const double* readings;
  double *stations, *outcome;
  std::size_t readings_stride, stations_stride, outcome_stride;  ///< from a group to the next
  int groups;
  double* scratch;  ///< kChainedScratch (chained_rows.h) doubles a station, aligned to 64 bytes
};

namespace isa_v3 {
void chained_batch(const ChainedLaneBatch& batch);
}
namespace isa_v4 {
void chained_batch(const ChainedLaneBatch& batch);
}

}  // namespace surveymc
