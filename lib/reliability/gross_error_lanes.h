#pragma once
/// Simulated trials of one station with and without gross errors, for both instruction sets (simd/lanes.h).
#include <cstdint>

#include "random/stream.h"
#include "reliability/gross_error_kernel.h"

namespace surveymc::reliability {

/// Values of a trial that are stored: the nine w, then those named.
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

namespace isa_v3 {
void gross_error_trials(const GrossErrorBatch& batch);
}
namespace isa_v4 {
void gross_error_trials(const GrossErrorBatch& batch);
}

}  // namespace surveymc::reliability
