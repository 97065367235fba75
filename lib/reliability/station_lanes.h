#pragma once
/// The kernel behind reliability maps, for both instruction sets (simd/lanes.h): lanes are points of a grid.
#include <array>
#include <cstddef>
#include <type_traits>

#include "reliability/station_kernel.h"
#include "simd/instruction_set.h"

namespace surveymc::reliability {

/// Quantities computed for an observation; the order of ObservationReliability.
inline constexpr std::size_t kMapQuantities = 8;

/// Points side by side: every pointer has `groups` times kGroup values. Where an output is null, it is not stored;
/// an observation without any output is not computed.
struct StationBatch {
  StationVariances variances;
  /// si, ci, st, ct, sa, ca, sd, cd, noise2 (the factor on the variance of the noise)
  std::array<const double*, 9> points;
  std::array<std::array<double*, kMapQuantities>, 9> outputs;  ///< [observation][quantity]
  std::array<std::array<double, kMapQuantities>, 9>
      units;          ///< detectable errors and effects on references: times these
  double angle_unit;  ///< effects on the attitude: times this
  int groups;
  /// Outputs are parts of long columns, so many that the processor does not see which lines of memory come next.
  bool long_columns = false;
};

/// Which specialisation.
enum class StationKernel { sse, sse_axial, mse_fixed, mse_shared, mse_systematic };

/// Calls use(a constant, whose value is the StationModel that a kernel is compiled for).
template <class Use>
void with_model(StationKernel kernel, const Use& use) {
  switch (kernel) {
    case StationKernel::sse:
      return use(std::integral_constant<StationModel, kSseModel>());
    case StationKernel::sse_axial:
      return use(std::integral_constant<StationModel, kSseAxialModel>());
    case StationKernel::mse_fixed:
      return use(std::integral_constant<StationModel, kMseFixedModel>());
    case StationKernel::mse_shared:
      return use(std::integral_constant<StationModel, kMseSharedModel>());
    case StationKernel::mse_systematic:
      return use(std::integral_constant<StationModel, kMseSystematicModel>());
  }
}

SURVEYMC_KERNEL(void station_batch(StationKernel kernel, const StationBatch& batch));

}  // namespace surveymc::reliability
