#pragma once
/// Medians on lanes of trials.
#include "simd/lanes.h"

namespace surveymc::multistation {

using namespace simd;

/// Sorts x[0], ..., x[n - 1], rising, each lane by itself: Batcher's merge exchange (Knuth, TAOCP 3, 5.2.2 M), whose
/// comparisons do not depend on the values.
template <class T>
void sort_lanes(T* x, int n) {
  int top = 1;
  while (2 * top < n) top *= 2;
  for (int p = top; p > 0; p /= 2) {
    int distance = p;
    for (int q = top, r = 0;; q /= 2) {
      for (int i = 0; i + distance < n; ++i) {
        if ((i & p) != r) continue;
        const T a = x[i], b = x[i + distance];
        const auto in_order = a < b;
        x[i] = select(in_order, a, b);
        x[i + distance] = select(in_order, b, a);
      }
      if (q == p) break;
      distance = q - p;
      r = p;
    }
  }
}

/// The median of n >= 1 values; of an even number the mean of the two in the middle. Sorts them.
template <class T>
T median_of(T* x, int n) {
  sort_lanes(x, n);
  return T(0.5) * (x[(n - 1) / 2] + x[n / 2]);
}

}  // namespace surveymc::multistation
