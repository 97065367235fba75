#include "random/mixing_draws_lanes.h"

#include "random/draw_address.h"

namespace surveymc::random::SURVEYMC_ISA {

using namespace simd;
using simd::store;

void mixing_normals(const MixingNormalsBatch& b, const Stream& stream) {
  using T = Lanes;
  for (int group = 0; group < b.groups; ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
      const auto g = static_cast<std::size_t>(group);
      const DrawAddress<T> from = draw_address<T>(
          consecutive<T>(b.first_trial + static_cast<std::uint64_t>(group * kGroup + lane)), b.antithetic);
      const auto z = stream.normals<T>(from.trial, b.channel, Bits<T>(static_cast<std::uint64_t>(b.index / 4)));
      store(b.row + g * b.stride + static_cast<std::size_t>(lane), z[b.index % 4]);
    }
}

}  // namespace surveymc::random::SURVEYMC_ISA
