#pragma once
/// Kernels on the normals of trials, for both instruction sets (simd/lanes.h). Rows are kGroup doubles apart.
#include <cstddef>
#include <cstdint>

#include "random/stream.h"
#include "simd/instruction_set.h"

namespace surveymc::rare {

/// A call of the stream: four normals, indices 4 call .. 4 call + 3 of the channel.
struct NormalCall {
  random::Channel channel{};
  std::uint32_t call = 0;
};

/// The calls' normals of 8 `groups` trials: row 4 i + k of a group is normal k of call i.
struct NormalBatch {
  const NormalCall* calls;
  std::size_t call_count, rows;  ///< rows in memory: rows beyond are not written
  std::uint64_t first_trial;
  std::size_t groups;
  double* z;
  std::size_t stride;  ///< from one group to the next
};

/// Of one group. `basis`: n x r, column by column. y (r rows) = basis' z, or z = z + basis y.
struct BasisBatch {
  const double* basis;
  std::size_t n, r;
  double* z;
  double* y;
};

SURVEYMC_KERNEL(void draw_normals(const NormalBatch& batch, const random::Stream& stream));
SURVEYMC_KERNEL(void project(const BasisBatch& batch));
SURVEYMC_KERNEL(void shift(const BasisBatch& batch));

}  // namespace surveymc::rare
