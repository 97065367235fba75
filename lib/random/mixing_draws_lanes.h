#pragma once
/// The kernel behind draw_mixing, for both instruction sets (simd/lanes.h).
#include <cstddef>
#include <cstdint>

#include "random/stream.h"
#include "simd/instruction_set.h"

namespace surveymc::random {

/// The normal of one slot for all trials, into one row.
struct MixingNormalsBatch {
  Channel channel{};
  std::uint32_t index;
  std::uint64_t first_trial;
  bool antithetic;
  int groups;
  double* row;
  std::size_t stride;
};

SURVEYMC_KERNEL(void mixing_normals(const MixingNormalsBatch& batch, const Stream& stream));

}  // namespace surveymc::random
