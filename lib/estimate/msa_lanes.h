#pragma once
/// The kernel behind the estimator "msa", for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "estimate/msa_valley.h"
#include "simd/instruction_set.h"

namespace surveymc::estimate {

/// Raw view of a batch of readings and of the estimates to fill; rows are kGroup doubles apart.
struct MsaBatch {
  MsaData first;  ///< data of group 0
  std::size_t magnetic_stride, down_stride, reference_stride;
  double *parameters, *cost, *iterations, *converged;
  std::size_t parameters_stride, scalar_stride;  ///< of `parameters`, and of each of the other three
  int groups;
  double total;  ///< nT
  NewtonOptions options;
  /// Where to start: both null for unit gains. Lanes that do not converge are left to the caller.
  const MsaExpansion* expansion;
  const MsaValley* valley;
  bool goes_on = false;  ///< start where `parameters` are
};

SURVEYMC_KERNEL(void msa_solve_batch(const MsaBatch& batch));

}  // namespace surveymc::estimate
