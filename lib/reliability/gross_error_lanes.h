#pragma once
/// Simulated trials of one station with and without gross errors, for both instruction sets (simd/lanes.h).
#include <cstdint>

#include "random/stream.h"
#include "reliability/gross_error_kernel.h"
#include "simd/instruction_set.h"

namespace surveymc::reliability {

/// Rows of the stored values of a trial: the nine w, then the named ones.
enum TestRow { kOmegaRow = 9, kLargestRow, kTiedRow, kConvergedRow, kTestRows };

/// Rows are kGroup doubles apart; a group has kTestRows of them.
struct GrossErrorBatch {
  StationScale scale;
  std::array<double, kStationObservations> truth, error;  ///< relative
  random::Stream stream;
  std::uint64_t first_trial;
  int groups;
  double *without, *with;  ///< tests without and with the errors, of the same noise
};

SURVEYMC_KERNEL(void gross_error_trials(const GrossErrorBatch& batch));

}  // namespace surveymc::reliability
