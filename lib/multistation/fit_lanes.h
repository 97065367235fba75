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

/// Readings of the register at `lane` of a group.
[[gnu::always_inline]] inline FitData data_of(const FitBatch& b, std::size_t group, std::size_t lane) {
  FitData d = b.first;
  d.gravity += group * b.gravity_stride + lane;
  d.magnetic += group * b.magnetic_stride + lane;
  d.reference += group * b.reference_stride + lane;
  if (d.weight) d.weight += group * b.weight_stride + lane;
  return d;
}

/// Value of a parameter, in its unit, whose unknown of the plan is 1 in units of the scales.
[[gnu::always_inline]] inline double unit_of(const FitBatch& b, std::size_t parameter) {
  const auto place = static_cast<std::size_t>(b.places[parameter]);
  return b.plan->scale[static_cast<std::size_t>(b.plan->kinds[place / 3]) + place % 3];
}

/// Stores parameters and errors of the reference of unknowns `x`.
template <class T>
void store_estimate(const FitBatch& b, std::size_t group, std::size_t lane, const T* x) {
  const FitPlan& plan = *b.plan;
  for (std::size_t i = 0; i < static_cast<std::size_t>(b.parameters); ++i)
    simd::store(b.estimate + group * b.estimate_stride + i * kGroup + lane, T(unit_of(b, i)) * x[b.places[i]]);
  const bool estimated = plan.kinds[static_cast<std::size_t>(plan.kind_count - 1)] == kReferenceKind;
  for (std::size_t i = 0; i < 3; ++i)
    simd::store(
        b.reference + group * b.reference_out_stride + i * kGroup + lane,
        estimated ? T(plan.scale[kReferenceKind + i]) * x[static_cast<std::size_t>(plan.size()) - 3 + i] : T(0.0));
}

SURVEYMC_KERNEL(void fit_batch(const FitBatch& batch))
SURVEYMC_KERNEL(void correct_batch(const FitBatch& batch))
SURVEYMC_KERNEL(void residual_batch(const FitBatch& batch))

}  // namespace surveymc::multistation
