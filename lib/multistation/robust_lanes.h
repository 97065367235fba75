#pragma once
/// The kernel behind robust.h, for both instruction sets (simd/lanes.h).
#include <cstddef>

#include "multistation/fit_lanes.h"
#include "multistation/robust_kernel.h"

namespace surveymc::multistation {

/// A model's residuals and their derivatives as robust_kernel.h wants them, in units of the plan's scales, of the
/// unknowns of its kinds. C: 3, or 2 without gravity.
template <class T, int C>
struct FitRows {
  const FitPlan& plan;
  FitData data;

  template <class Mask>
  void operator()(const T* x, T* residual, T* jacobian, const Mask& which) const {
    const T zero(0.0);
    const auto kinds = static_cast<std::size_t>(plan.kind_count);
    const Correction<T> c = correction_at(plan, x);
    constexpr std::size_t kFirst = kResiduals - C;
    const double *gravity = data.gravity, *magnetic = data.magnetic, *reference = data.reference;
    for (int k = 0; k < data.stations; ++k) {
      const StationTerms<T> s = station_terms<T>(plan, c, gravity, magnetic, reference, T(1.0));
      for (std::size_t j = kFirst; j < kResiduals; ++j) {
        *residual = select(which, s.r[j], *residual);
        ++residual;
        for (std::size_t a = 0; a < kinds; ++a, jacobian += 3) {
          const int kind = plan.kinds[a];
          std::array<T, 3> row;
          if (kind == kReferenceKind)
            row = {T(j == 0 ? -plan.per_size[0] : 0.0),
                   T(j == 1   ? -plan.per_size[1] * plan.first_by_total
                     : j == 2 ? -plan.per_size[2] * plan.second_by_total
                              : 0.0),
                   T(j == 1   ? -plan.per_size[1] * plan.first_by_dip
                     : j == 2 ? -plan.per_size[2] * plan.second_by_dip
                              : 0.0)};
          else if (is_of_accelerometer(kind))
            row = columns_of(kind, s.by_gravity[j], s.g);
          else if (j > 0)
            row = columns_of(kind, s.by_field[j], s.b);
          else
            row = {zero, zero, zero};
          for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t at = static_cast<std::size_t>(kind) + i;
            jacobian[i] = select(which, plan.free[at] ? T(plan.scale[at]) * row[i] : zero, jacobian[i]);
          }
        }
      }
      gravity += 3 * kGroup;
      magnetic += 3 * kGroup;
      reference += data.reference_stride * kGroup;
    }
  }
};

struct RobustBatch {
  FitBatch fit;           ///< estimate, reference and converged are written; first.weight: given weights, or null
  RobustProblem problem;  ///< subsets: those of the first group
  RobustOptions options;
  std::size_t subsets_stride = 0;  ///< numbers of stations from a group's subsets to the next one's
  double *weights, *scale, *reweightings;
  std::size_t weights_stride, scalar_stride;
  const double* start;  ///< of all trials: unknowns of the plan, in units of its scales
  double* scratch;      ///< RobustMemory::size values of a whole group, aligned to 64 bytes
};

SURVEYMC_KERNEL(void robust_batch(const RobustBatch& batch))

}  // namespace surveymc::multistation
