#pragma once
/// The kernel behind aakr.h, for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "simd/lanes.h"

namespace surveymc::monitoring {

/// Raw view of a memory and of the vectors to predict. Rows of `memory` are `padded` doubles long, a multiple of
/// kGroup; `valid` is 1 where there is a memory vector and 0 where there is only padding.
struct AakrBatch {
  const double *memory, *valid;  ///< [sensor][vector], [vector]
  std::size_t padded;
  int sensors;
  double minus_half_per_h2;  ///< -1 / (2 h^2)
  const double* queries;     ///< [query][sensor]
  int count;
  double* predictions;  ///< [query][sensor]
  double* nearest;      ///< [query]: distance to the nearest memory vector
  double* scratch;      ///< padded doubles
};

namespace isa_v3 {
void aakr_predict(const AakrBatch& batch);
}
namespace isa_v4 {
void aakr_predict(const AakrBatch& batch);
}

}  // namespace surveymc::monitoring
