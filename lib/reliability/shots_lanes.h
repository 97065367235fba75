#pragma once
/// Simulated trials of several stations with and without gross errors, for both instruction sets (simd/lanes.h).
#include <cstdint>

#include "random/stream.h"
#include "reliability/shots_kernel.h"
#include "simd/instruction_set.h"

namespace surveymc::reliability {

/// Rows of the stored values of a trial: the w of all observations, then these three, then V row by row.
struct ShotsRows {
  std::size_t observations, unknowns;

  int omega() const { return static_cast<int>(observations); }
  int largest() const { return omega() + 1; }
  int converged() const { return omega() + 2; }
  int base() const { return omega() + 3; }
  /// Without V.
  int tests() const { return base(); }
  int all() const { return base() + static_cast<int>(observations * unknowns); }
};

/// Rows are kGroup doubles apart.
struct ShotsBatch {
  ShotsModel model;
  std::array<double, kMostShotObservations> truth, error;  ///< relative; the dip less the true one
  random::Stream stream;
  std::uint64_t first_trial;
  int groups;
  double* without;  ///< ShotsRows::tests() rows a group
  double* with;     ///< ShotsRows::all() rows a group
};

SURVEYMC_KERNEL(void shots_trials(const ShotsBatch& batch));

}  // namespace surveymc::reliability
