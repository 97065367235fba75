#include "random/mixing_draws.h"

#include "random/mixing_draws_lanes.h"

namespace surveymc::random {

void draw_mixing(const Stream& stream, const std::vector<MixingSlot>& slots, std::uint64_t first_trial, bool antithetic,
                 int groups, double* rows, std::size_t stride) {
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const MixingSlot& slot = slots[i];
    double* row = rows + 2 * i * simd::kGroup;
    const MixingNormalsBatch batch{slot.channel, slot.index, first_trial, antithetic, groups, row, stride};
    simd::run_kernel<isa_v3::mixing_normals, isa_v4::mixing_normals>(batch, stream);
    for (int g = 0; g < groups; ++g) {
      double* at = row + static_cast<std::size_t>(g) * stride;
      for (int lane = 0; lane < simd::kGroup; ++lane) {
        const MixingLaw::Draw d = slot.law->draw(at[lane]);
        at[lane] = d.factor;
        at[simd::kGroup + lane] = d.shift;
      }
    }
  }
}

}  // namespace surveymc::random
