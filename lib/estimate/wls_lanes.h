#pragma once
/// The kernel behind wls.h, for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "simd/instruction_set.h"
#include "simd/lanes.h"

namespace surveymc::estimate {

/// Raw view of a batch; rows are kGroup doubles apart. `truth` holds 3 numbers a station.
struct WlsBatch {
  const double *truth, *magnetic, *assumed_sd;  ///< assumed_sd null: `sd` everywhere
  std::size_t magnetic_stride, assumed_stride;
  int stations, groups;
  double sd, gain_weight, bias_weight[3],
      total;  ///< weights 1 / sd^2 of the priors, 0 for none; total scales the unknowns
  double *parameters, *claimed_variance, *cost, *iterations, *converged;
  std::size_t parameters_stride, scalar_stride;
};

SURVEYMC_KERNEL(void wls_batch(const WlsBatch& batch));

}  // namespace surveymc::estimate
