#pragma once
/// Stores into many long columns side by side. A line of memory is asked for two lines before it is written: the
/// processor foresees a few columns, not dozens, and would wait for every line when its turn comes.
#include "simd/lanes.h"

namespace surveymc::simd {
inline namespace SURVEYMC_ISA {

inline void store_ahead(double* p, const Lanes& x) {
  constexpr int kAhead = 2 * 64 / sizeof(double);  // past the end of a column nothing happens
#if defined(__x86_64__)
  // "I shall write it", which the builtin says only where the compiler is told that the processor knows it; one that
  // does not takes it for no instruction.
  asm volatile("prefetchw %0" : : "m"(p[kAhead]));
#else
  __builtin_prefetch(p + kAhead, 1);
#endif
  store(p, x);
}

}  // namespace SURVEYMC_ISA
}  // namespace surveymc::simd
