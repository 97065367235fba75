#pragma once
/// The kernel behind side_by_side.h, for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "chained/descent_kernel.h"
#include "simd/instruction_set.h"

namespace surveymc::chained {

/// Groups of kGroup starts; rows are kGroup doubles apart, `..._stride` from a group to the next. Outcome: cost,
/// iterations, number of the Status.
struct DescentOutcome {
  double* rows;
  std::size_t stride;
};
/// Rows of a station's point: n, d, chained states. Start and end.
inline constexpr int kPointRows = 6 + kChainStates;
struct ChainDescentBatch {
  DescentModel model;
  Options options;
  double* points;
  std::size_t points_stride;
  DescentOutcome outcome;
  int groups;
  double* scratch;  ///< kDescentScratch doubles a station, aligned to 64 bytes
};
inline constexpr std::size_t kDescentScratch = simd::kGroup * (12 + 18 + 6 + 27 + 18 + 45);

/// A group of starts at every station: six rows, n and d.
struct AttitudeDescentBatch {
  DescentModel model;
  Options options;
  double* frames;
  std::size_t frames_stride;
  DescentOutcome outcome;
};
struct OffsetDescentBatch {
  OffsetModel model;
  Options options;
  double* offsets;  ///< one group: six rows
  DescentOutcome outcome;
};

SURVEYMC_KERNEL(void descend_chains(const ChainDescentBatch&));
SURVEYMC_KERNEL(void descend_attitudes(const AttitudeDescentBatch&));
SURVEYMC_KERNEL(void descend_offsets(const OffsetDescentBatch&));

}  // namespace surveymc::chained
