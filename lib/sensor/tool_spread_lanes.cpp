#include "sensor/tool_spread_lanes.h"

#include "random/draw_address.h"

namespace surveymc::sensor::SURVEYMC_ISA {

using namespace simd;
using simd::store;

using T = Lanes;

void spread_tools(const ToolSpreadBatch& b) {
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>) {
      const random::DrawAddress<T> from =
          random::draw_address<T>(consecutive<T>(b.first_trial + group * kGroup + lane), b.antithetic);
      const auto first = b.stream.normals<T>(from.trial, random::Channel::tool_errors, Bits<T>(0)),
                 second = b.stream.normals<T>(from.trial, random::Channel::tool_errors, Bits<T>(1));
      std::array<T, 6> draw{first[0], first[1], first[2], first[3], second[0], second[1]}, d;
      for (T& x : draw) x = random::signed_draw(x, from);
      for (std::size_t i = 0; i < 6; ++i) {
        d[i] = T(b.sd[i]) * draw[i];
        store(b.deviation + group * b.deviation_stride + i * kGroup + lane, d[i]);
      }
      double* magnetic = b.magnetic + group * b.magnetic_stride + lane;
      for (int k = 0; k < b.stations; ++k)
        for (std::size_t i = 0; i < 3; ++i) {
          const std::size_t r = 3 * static_cast<std::size_t>(k) + i;
          store(magnetic + r * kGroup, load<T>(magnetic + r * kGroup) + fma(d[i], T(b.field[r]), d[3 + i]));
        }
      if (b.sums)
        for (std::size_t q = 0; q < NoiseWeights::kSums; ++q) {
          double* at = b.sums + group * b.sums_stride + q * kGroup + lane;
          T sum = load<T>(at);
          for (std::size_t i = 0; i < 6; ++i) sum = fma(T(b.weights[i * NoiseWeights::kSums + q]), draw[i], sum);
          store(at, sum);
        }
    }
}

void draw_assumed_sd(const AssumedSdBatch& b) {
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>) {
      const Bits<T> trial = consecutive<T>(b.first_trial + group * kGroup + lane);
      for (int r = 0; r < b.rows; r += 4) {
        const auto u =
            b.stream.uniforms<T>(trial, random::Channel::assumed_noise, Bits<T>(static_cast<std::uint64_t>(r / 4)));
        for (int i = 0; i < 4 && r + i < b.rows; ++i) {
          const T x = T(b.size) * u[static_cast<std::size_t>(i)];
          store(b.assumed_sd + group * b.stride + static_cast<std::size_t>((r + i) * kGroup) + lane,
                b.law == AssumedNoise::random_variance ? sqrt(x) : x);
        }
      }
    }
}

}  // namespace surveymc::sensor::SURVEYMC_ISA
