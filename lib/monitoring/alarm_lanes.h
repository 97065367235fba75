#pragma once
/// The tests of sequential_tests.h with several settings on one signal, side by side on lanes, for both instruction
/// sets (simd/lanes.h). The result is the times of their alarms, of either side.
#include <cstddef>

#include "simd/instruction_set.h"
#include "simd/lanes.h"

namespace surveymc::monitoring {

/// Tests of one kind and their results. Unused places may have any settings.
struct AlarmLanes {
  enum class Kind { sprt, cusum, threshold } kind;
  /// SPRT: slope M / sigma^2, M / 2, ln A, ln B. CUSUM: allowance, threshold. Threshold: threshold.
  double settings[4][simd::kGroup];
  double sum[2][simd::kGroup];             ///< of both sides
  double first[simd::kGroup];              ///< time of the first alarm; infinite: none
  double first_after_start[simd::kGroup];  ///< from `start_h` on
  double count[simd::kGroup];              ///< of samples with an alarm
};

/// Samples of one sensor that follow those of the call before: signal[i * stride] at time_h[i].
struct AlarmSignal {
  const double *signal, *time_h;
  std::size_t stride, count;
  double start_h;
};

SURVEYMC_KERNEL(void update_alarms(AlarmLanes& tests, const AlarmSignal& signal));

}  // namespace surveymc::monitoring
