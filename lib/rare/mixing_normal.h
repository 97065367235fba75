#pragma once
/// Errors that are no normals among those that a limit state takes: their V (random/mixing_law.h) is one more normal,
/// through its quantile.
#include <cstdint>
#include <memory>
#include <vector>

#include "random/mixing_law.h"

namespace surveymc::rare {

/// The normal of a V, its law, and the normals of the errors that have it.
struct MixingNormal {
  std::uint32_t row = 0;
  std::shared_ptr<const random::MixingLaw> law;
  std::vector<std::uint32_t> of;
};

}  // namespace surveymc::rare
