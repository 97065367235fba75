#pragma once
/// Stores that pass the caches by, for results that no one reads soon: a line of memory is then not read before it is
/// written. Only where a register is a whole line; elsewhere they are plain stores.
#include "simd/lanes.h"

namespace surveymc::simd {
inline namespace SURVEYMC_ISA {

/// `p` must be aligned to 64 bytes.
inline void stream(double* p, const Lanes& x) {
#if SURVEYMC_LANES == 8
  _mm512_stream_pd(p, __m512d(x.v));
#else
  store(p, x);
#endif
}
/// Call it after the last stream() and before another thread may read.
inline void end_streams() {
#if SURVEYMC_LANES == 8
  _mm_sfence();
#endif
}

}  // namespace SURVEYMC_ISA
}  // namespace surveymc::simd
