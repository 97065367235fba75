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

constexpr std::size_t kDirections = 3;  // that one pass over the normals serves

/// y of directions first .. first + kDirections - 1, or of those that are left: the last one is then made again.
void project_some(const BasisBatch& b, std::size_t lane, std::size_t first) {
  const double* u[kDirections];
  T even[kDirections], odd[kDirections];
  for (std::size_t k = 0; k < kDirections; ++k) {
    u[k] = b.basis + (first + k < b.r ? first + k : b.r - 1) * b.n;
    even[k] = odd[k] = T(0.0);
  }
  std::size_t i = 0;
  for (; i + 1 < b.n; i += 2) {
    const T z0 = load<T>(b.z + i * kGroup + lane), z1 = load<T>(b.z + (i + 1) * kGroup + lane);
    for (std::size_t k = 0; k < kDirections; ++k) {
      even[k] = fma(T(u[k][i]), z0, even[k]);
      odd[k] = fma(T(u[k][i + 1]), z1, odd[k]);
    }
  }
  if (i < b.n) {
    const T z0 = load<T>(b.z + i * kGroup + lane);
    for (std::size_t k = 0; k < kDirections; ++k) even[k] = fma(T(u[k][i]), z0, even[k]);
  }
  for (std::size_t k = 0; k < kDirections && first + k < b.r; ++k)
    store(b.y + (first + k) * kGroup + lane, even[k] + odd[k]);
}

/// z + the part of R directions, in their order.
template <std::size_t R>
void shift_by(const BasisBatch& b, std::size_t lane, std::size_t first) {
  const double* u[R];
  T y[R];
  for (std::size_t k = 0; k < R; ++k) {
    u[k] = b.basis + (first + k) * b.n;
    y[k] = load<T>(b.y + (first + k) * kGroup + lane);
  }
  for (std::size_t i = 0; i < b.n; ++i) {
    T z = load<T>(b.z + i * kGroup + lane);
    for (std::size_t k = 0; k < R; ++k) z = fma(T(u[k][i]), y[k], z);
    store(b.z + i * kGroup + lane, z);
  }
}

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
    for (std::size_t j = 0; j < b.r; j += kDirections) project_some(b, lane, j);
}

void shift(const BasisBatch& b) {
  for (std::size_t lane = 0; lane < kGroup; lane += kLanes)
    for (std::size_t j = 0; j < b.r; j += kDirections) {
      if (b.r - j >= kDirections)
        shift_by<kDirections>(b, lane, j);
      else if (b.r - j == 2)
        shift_by<2>(b, lane, j);
      else
        shift_by<1>(b, lane, j);
    }
}

}  // namespace surveymc::rare::SURVEYMC_ISA
