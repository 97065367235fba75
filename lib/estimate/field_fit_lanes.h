#pragma once
/// The kernel behind the estimators of field_fit.h, for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "estimate/field_fit_kernel.h"
#include "simd/instruction_set.h"

namespace surveymc::estimate {

/// Raw view of a batch of readings and of the estimates to fill; rows are kGroup doubles apart.
struct FieldFitBatch {
  FieldFitData first;  ///< data of group 0
  std::size_t magnetic_stride, down_stride, reference_stride;
  double *parameters, *cost, *iterations, *converged;
  double* reference_estimate;  ///< Bh, Bv (nT) of the first station; written for a joint estimate
  std::size_t parameters_stride, scalar_stride, reference_estimate_stride;
  int groups;
  FieldFitModel model;
  NewtonOptions options;
};

SURVEYMC_KERNEL(void field_fit_batch(const FieldFitBatch& batch));

}  // namespace surveymc::estimate
