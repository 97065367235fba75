#pragma once
/// The kernel behind aakr.h, for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "simd/instruction_set.h"
#include "simd/lanes.h"

namespace surveymc::monitoring {

/// Memory vectors in a tile, which are computed together.
inline constexpr std::size_t kTile = 4 * simd::kGroup;

/// Raw view of a memory and of the vectors to predict. All but the queries and results is in the unit 1 / scale of z,
/// in which log2 of a weight is the square of a distance, with a minus. Vectors stand in the order of their projections
/// on `direction`. Rows of `memory` are `padded` = kTile * tiles doubles long; padding is so far from all queries that
/// its weight is 0.
struct AakrBatch {
  const double* memory;      ///< [sensor][vector]
  const double* direction;   ///< [sensor], of length 1
  const double *low, *high;  ///< [tile]: projections of its first and last vector
  std::size_t padded, tiles;
  int sensors;
  double cutoff;          ///< squared distance beyond the nearest at which weights are negligible
  double rounding;        ///< of a projection, at most
  double scale;           ///< sqrt(1 / (2 h^2 ln 2)), 1/z
  const double* queries;  ///< [query][sensor], z
  int count;
  double* predictions;  ///< [query][sensor], z
  double* nearest;      ///< [query]: distance to the nearest memory vector, z; null: not wanted
  double* scaled;       ///< scratch: a query
  double* weights;      ///< scratch: padded doubles
};

SURVEYMC_KERNEL(void aakr_predict(const AakrBatch& batch));

}  // namespace surveymc::monitoring
