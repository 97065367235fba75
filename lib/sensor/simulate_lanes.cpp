#include "sensor/simulate_lanes.h"

#include "random/draw_address.h"
#include "simd/pack.h"

namespace surveymc::sensor::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

// Number of calls side by side. A call alone is one chain of Philox, logarithm and root, in which each operation waits
// for the one before. The 16 registers of AVX2 hold two calls, the 32 of AVX-512 five.
constexpr int kCalls = lane_count<T> == 8 ? 5 : 2;
using Calls = Pack<T, kCalls>;

/// Draws of size 1 of the law: element j of number i has index 4 (call + j) + i.
[[gnu::always_inline]] inline std::array<Calls, 4> unit_draws(NoiseLaw law, const random::Stream& stream,
                                                              const random::DrawAddress<T>& from,
                                                              random::Channel channel, int call) {
  const auto calls = Bits<Calls>::each([&](std::size_t j) { return Bits<T>(static_cast<std::uint64_t>(call) + j); });
  std::array<Calls, 4> x;
  if (law == NoiseLaw::gaussian || law == NoiseLaw::gaussian_half_open) {
    x = stream.normals<Calls>(from.trial, channel, calls);
    if (law == NoiseLaw::gaussian_half_open)
      for (Calls& v : x) v = abs(v);
  } else {
    x = stream.uniforms<Calls>(from.trial, channel, calls);
    if (law == NoiseLaw::uniform)
      for (Calls& v : x) v = fma(v, Calls(2.0), Calls(-1.0));
  }
  for (Calls& v : x) v = from_bits(to_bits(v) ^ from.sign);
  return x;
}

using Sums = std::array<T, NoiseWeights::kSums>;

void add_weighted(const double* weights, const T& draw, Sums& sums) {
  for (std::size_t q = 0; q < sums.size(); ++q) sums[q] = fma(T(weights[q]), draw, sums[q]);
}

/// clean + size * draw for `rows` rows; the draws' weighted sums if `weights` is not null.
void add_noise(const double* clean, int rows, NoiseLaw law, double size, const random::Stream& stream,
               const random::DrawAddress<T>& from, random::Channel channel, double* out, const double* weights,
               Sums& sums) {
  for (int first = 0; first < rows; first += 4 * kCalls) {
    const std::array<Calls, 4> draw = unit_draws(law, stream, from, channel, first / 4);
    const auto put = [&](int r) {
      const T& d = draw[static_cast<std::size_t>((r - first) % 4)].v[(r - first) / 4];
      store(out + r * kGroup, fma(T(size), d, T(clean[r])));
      if (weights) add_weighted(weights + r * NoiseWeights::kSums, d, sums);
    };
    if (first + 4 * kCalls <= rows) {
#pragma GCC unroll 16
      for (int r = first; r < first + 4 * kCalls; ++r) put(r);
    } else {
      for (int r = first; r < rows; ++r) put(r);
    }
  }
}

void normalise(int stations, double* down) {
  for (int k = 0; k < stations; ++k, down += 3 * kGroup) {
    const survey::Vec3<T> g{load<T>(down), load<T>(down + kGroup), load<T>(down + 2 * kGroup)};
    const survey::Vec3<T> u = scale(T(1.0) / norm(g), g);
    store(down, u.x);
    store(down + kGroup, u.y);
    store(down + 2 * kGroup, u.z);
  }
}

/// Horizontal and vertical part of a field of this total (nT) and dip (rad), one row each.
void store_reference(const T& total, const T& dip, double* out) {
  const auto [sin_dip, cos_dip] = sincos(dip);
  store(out, total * cos_dip);
  store(out + kGroup, total * sin_dip);
}

/// Horizontal and vertical reference of each row pair: total and dip with their errors of this trial. `mixing`: of
/// these trials; `made`: the draws, or null.
void draw_reference(const SimulateBatch& b, const random::DrawAddress<T>& from, const double* mixing,
                    const double* made, double* out, Sums& sums) {
  for (int k = 0; k < b.rows.reference_pairs; k += 2) {  // one call serves two stations
    std::array<T, 4> draw{T(0.0), T(0.0), T(0.0), T(0.0)};
    if (made != nullptr) {
      for (std::size_t i = 0; i < (k + 1 < b.rows.reference_pairs ? 4 : 2); ++i)
        draw[i] = load<T>(made + (2 * static_cast<std::size_t>(k) + i) * kGroup);
    } else if (b.noise.reference != ReferenceNoise::none) {
      draw =
          b.stream.normals<T>(from.trial, random::Channel::reference_field, Bits<T>(static_cast<std::uint64_t>(k / 2)));
      for (T& v : draw) v = random::signed_draw(v, from);
    }
    for (int i = 0; i < 2 && k + i < b.rows.reference_pairs; ++i) {
      const auto j = static_cast<std::size_t>(2 * i);
      for (std::size_t part = 0; part < 2 && mixing != nullptr; ++part) {
        const std::int32_t slot = b.slot_of[2 * (k + i) + static_cast<int>(part)];
        if (slot < 0) continue;
        const double* v = mixing + 2 * slot * kGroup;
        draw[j + part] = fma(load<T>(v), draw[j + part], load<T>(v + kGroup));
      }
      if (b.reference_weights)
        for (std::size_t part = 0; part < 2; ++part)
          add_weighted(b.reference_weights + (2 * (k + i) + static_cast<int>(part)) * NoiseWeights::kSums,
                       draw[j + part], sums);
      store_reference(fma(T(b.noise.reference_total), draw[j], T(b.rows.total)),
                      fma(T(b.noise.reference_dip), draw[j + 1], T(b.rows.dip)), out + 2 * (k + i) * kGroup);
    }
  }
}

}  // namespace

void simulate(const SimulateBatch& b) {
  for (int group = 0; group < b.groups; ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
      const random::DrawAddress<T> from = random::draw_address<T>(
          consecutive<T>(b.first_trial + static_cast<std::uint64_t>(group * kGroup + lane)), b.noise.antithetic);
      const auto g = static_cast<std::size_t>(group);
      Sums sums;
      for (T& s : sums) s = T(0.0);
      add_noise(b.rows.clean_magnetic, 3 * b.rows.stations, b.noise.law, b.noise.magnetometer, b.stream, from,
                random::Channel::magnetometer_noise, b.rows.magnetic + g * b.rows.magnetic_stride + lane,
                b.magnetometer_weights, sums);
      if (group == 0 || b.rows.down_stride > 0) {
        double* down = b.rows.down + g * b.rows.down_stride + lane;
        if (b.noise.accelerometer > 0) {
          add_noise(b.rows.clean_gravity, 3 * b.rows.stations, NoiseLaw::gaussian, b.noise.accelerometer, b.stream,
                    from, random::Channel::accelerometer_noise, down, b.accelerometer_weights, sums);
          normalise(b.rows.stations, down);
        } else {  // the same direction goes to all lanes of the one shared group
          for (int r = 0; r < 3 * b.rows.stations; ++r) store(down + r * kGroup, T(b.rows.clean_down[r]));
        }
      }
      draw_reference(b, from, b.mixing == nullptr ? nullptr : b.mixing + g * b.mixing_stride + lane,
                     b.made == nullptr ? nullptr : b.made + g * b.made_stride + lane,
                     b.rows.reference + g * b.rows.reference_stride + lane, sums);
      if (b.sums)
        for (std::size_t q = 0; q < sums.size(); ++q) store(b.sums + g * b.sums_stride + q * kGroup + lane, sums[q]);
    }
}

void readings_of_normals(const GivenNormalsBatch& b) {
  for (int group = 0; group < b.groups; ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
      const auto g = static_cast<std::size_t>(group);
      const auto normal = [&](const double* z, int r) { return load<T>(z + g * b.z_stride + r * kGroup + lane); };
      double* magnetic = b.rows.magnetic + g * b.rows.magnetic_stride + lane;
      for (int r = 0; r < 3 * b.rows.stations; ++r)
        store(magnetic + r * kGroup,
              fma(T(b.magnetometer_sd), normal(b.magnetometer_z, r), T(b.rows.clean_magnetic[r])));
      if (b.tool_z) {
        std::array<T, 6> d;
        for (int i = 0; i < 6; ++i) d[static_cast<std::size_t>(i)] = T(b.tool_sd[i]) * normal(b.tool_z, i);
        for (int r = 0; r < 3 * b.rows.stations; ++r) {
          const auto i = static_cast<std::size_t>(r % 3);
          store(magnetic + r * kGroup, load<T>(magnetic + r * kGroup) + fma(d[i], T(b.rows.clean_field[r]), d[3 + i]));
        }
      }
      if (group == 0 || b.rows.down_stride > 0) {
        double* down = b.rows.down + g * b.rows.down_stride + lane;
        for (int r = 0; r < 3 * b.rows.stations; ++r)
          store(down + r * kGroup,
                b.accelerometer_z ? fma(T(b.accelerometer_sd), normal(b.accelerometer_z, r), T(b.rows.clean_gravity[r]))
                                  : T(b.rows.clean_down[r]));
        if (b.accelerometer_z) normalise(b.rows.stations, down);
      }
      double* reference = b.rows.reference + g * b.rows.reference_stride + lane;
      for (int k = 0; k < b.rows.reference_pairs; ++k) {
        const T z_total = b.reference_z ? normal(b.reference_z, 2 * k) : T(0.0),
                z_dip = b.reference_z ? normal(b.reference_z, 2 * k + 1) : T(0.0);
        store_reference(fma(T(b.total_sd), z_total, T(b.rows.total)), fma(T(b.dip_sd), z_dip, T(b.rows.dip)),
                        reference + 2 * k * kGroup);
      }
    }
}

}  // namespace surveymc::sensor::SURVEYMC_ISA
