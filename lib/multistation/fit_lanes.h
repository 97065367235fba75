#pragma once
/// The kernels behind fit_block and its relatives, for both instruction sets (simd/lanes.h).
#include "multistation/fit_kernel.h"
#include "simd/instruction_set.h"
#include "survey/readings.h"

namespace surveymc::multistation {

/// Raw view of a batch; rows are kGroup doubles apart, groups `*_stride` doubles.
struct FitBatch {
  const FitPlan* plan;
  FitData first;  ///< data of group 0
  std::size_t gravity_stride, magnetic_stride, reference_stride, weight_stride;
  int groups;
  /// Unknown of the plan (3 a + i) of each parameter of the set.
  std::array<int, kParameters> places;
  int parameters;
  double *estimate, *reference, *variance;  ///< variance: may be null
  std::size_t estimate_stride, reference_out_stride, variance_stride;
  double *cost, *iterations, *converged;
  std::size_t scalar_stride;
  /// Of correct_batch: where corrected readings go. Of residual_batch: residuals.
  double *gravity_out, *magnetic_out, *residuals;
  std::size_t residuals_stride;
};

struct SixAxisBlock;
struct FitBlock;
/// The view of a block (fit.h). `weights` may be null.
FitBatch batch_of(const SixAxisBlock& readings, const FitPlan& plan, const ParameterSet& set, const FitBlock& out,
                  const survey::LaneArray* weights);

SURVEYMC_KERNEL(void fit_batch(const FitBatch& batch))
SURVEYMC_KERNEL(void correct_batch(const FitBatch& batch))
SURVEYMC_KERNEL(void residual_batch(const FitBatch& batch))

}  // namespace surveymc::multistation
