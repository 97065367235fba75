#include "rare/normals_lanes.h"

#include "simd/pack.h"

namespace surveymc::rare::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;
constexpr std::size_t kLanes = lane_count<T>;
// Calls side by side, as the wells have them (propagate/drawn_well_lanes.cpp).
constexpr std::size_t kCalls = kLanes == 8 ? 5 : 2;
using Calls = Pack<T, kCalls>;

}  // namespace

void draw_normals(const NormalBatch& b, const random::Stream& stream) {
  for (std::size_t g = 0; g < b.groups; ++g)
    for (std::size_t lane = 0; lane < kGroup; lane += kLanes) {
      const Bits<T> trial = consecutive<T>(b.first_trial + g * kGroup + lane);
      double* z = b.z + g * b.stride + lane;
      for (std::size_t first = 0; first < b.call_count;) {
        const random::Channel channel = b.calls[first].channel;
        std::size_t count = 1;
        while (count < kCalls && first + count < b.call_count && b.calls[first + count].channel == channel) ++count;
        const auto calls = Bits<Calls>::each(
            [&](std::size_t j) { return Bits<T>(std::uint64_t{b.calls[first + (j < count ? j : count - 1)].call}); });
        const auto normals = stream.normals<Calls>(trial, channel, calls);
        for (std::size_t j = 0; j < count; ++j)
          for (std::size_t i = 0; i < 4; ++i)
            if (const std::size_t row = 4 * (first + j) + i; row < b.rows) store(z + row * kGroup, normals[i].v[j]);
        first += count;
      }
    }
}

void project(const BasisBatch& b) {
  for (std::size_t lane = 0; lane < kGroup; lane += kLanes)
    for (std::size_t j = 0; j < b.r; ++j) {
      T even(0.0), odd(0.0);
      std::size_t i = 0;
      for (; i + 1 < b.n; i += 2) {
        even = fma(T(b.basis[j * b.n + i]), load<T>(b.z + i * kGroup + lane), even);
        odd = fma(T(b.basis[j * b.n + i + 1]), load<T>(b.z + (i + 1) * kGroup + lane), odd);
      }
      if (i < b.n) even = fma(T(b.basis[j * b.n + i]), load<T>(b.z + i * kGroup + lane), even);
      store(b.y + j * kGroup + lane, even + odd);
    }
}

void shift(const BasisBatch& b) {
  for (std::size_t lane = 0; lane < kGroup; lane += kLanes)
    for (std::size_t i = 0; i < b.n; ++i) {
      T z = load<T>(b.z + i * kGroup + lane);
      for (std::size_t j = 0; j < b.r; ++j) z = fma(T(b.basis[j * b.n + i]), load<T>(b.y + j * kGroup + lane), z);
      store(b.z + i * kGroup + lane, z);
    }
}

}  // namespace surveymc::rare::SURVEYMC_ISA
