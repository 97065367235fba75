#pragma once
/// Random numbers addressed by what they are for.
///
/// A draw is a pure function of (seed, study, trial, channel, index): not of thread, block, lane or the draws before
/// it. Two estimators on one seed see the same noise, and any single trial can be replayed.
///
/// Philox 4x32-10 (Salmon et al., SC'11; the tests compare it with Random123) gives four 32-bit words for each counter
///   (trial low, trial high, index / 4, study << 16 | channel), key = (seed low, seed high).
/// Two words make two normals (Box-Muller): 40 bits for the radius, which reaches 7.5 sigma, and 24 for the direction.
#include <array>
#include <cstdint>

#include "base/units.h"
#include "simd/math.h"

namespace surveymc {

/// What a draw is for. The numbers are part of every archived result: new channels go at the end.
enum class Channel : std::uint32_t {
  magnetometer_noise = 0,    ///< index 3 station + axis
  accelerometer_noise = 1,   ///< index 3 station + axis
  reference_field = 2,       ///< index 2 station + {0 total field, 1 dip}; station 0 when drawn once a run
  tool_errors = 3,           ///< index axis of the gain, 3 + axis of the bias: a tool drawn for every run
  assumed_noise = 4,         ///< index 3 station + axis: sizes that a weighted estimator assumes
  toolface = 5,              ///< index station; a slide takes that of its first station
  sensor_term = 6,           ///< errors constant in a run, index as in survey/sensor_terms.h
  gross_error_study = 20,    ///< index: number of the observation in the adjustment (reliability/adjustment.h)
  sensor_noise = 30,         ///< index sensors * sample + sensor: noise of a well's gauges
  survey_sensor_noise = 31,  ///< index 6 station + {accelerometer x, y, z, magnetometer x, y, z}: drift monitoring
  survey_reference = 32,     ///< index 4 station + {gravity, total field, dip}: scatter of the reference
  survey_toolface = 33,      ///< index station: uniform toolfaces of a made-up well
};

class Stream {
 public:
  Stream(std::uint64_t seed, std::uint32_t study) : study_(study) {
    std::uint64_t k0 = seed & 0xffffffffu, k1 = seed >> 32;
    for (auto& key : keys_) {
      key[0] = k0;
      key[1] = k1;
      k0 = (k0 + 0x9E3779B9u) & 0xffffffffu;
      k1 = (k1 + 0xBB67AE85u) & 0xffffffffu;
    }
  }

  /// Four standard normals, indices 4 call .. 4 call + 3, for the trials in the lanes. With a Pack (simd/pack.h) the
  /// calls, or the trials, may differ from element to element.
  template <class T>
  [[gnu::always_inline]] std::array<T, 4> normals(const Bits<T>& trial, Channel channel, const Bits<T>& call) const {
    const auto w = words<T>(trial, channel, call);
    const auto a = box_muller<T>(w[0], w[1]), b = box_muller<T>(w[2], w[3]);
    return {a.first, a.second, b.first, b.second};
  }
  /// Four uniforms in (0, 1), the same indices.
  template <class T>
  [[gnu::always_inline]] std::array<T, 4> uniforms(const Bits<T>& trial, Channel channel, const Bits<T>& call) const {
    const auto w = words<T>(trial, channel, call);
    std::array<T, 4> u;
    for (std::size_t i = 0; i < 4; ++i) u[i] = fma(small_to_double(w[i]), T(0x1p-32), T(0x1p-33));
    return u;
  }
  /// One standard normal by its address: the readable definition.
  double normal(std::uint64_t trial, Channel channel, std::uint32_t index) const {
    return normals<double>(trial, channel, std::uint64_t{index / 4})[index % 4];
  }

 private:
  template <class T>
  [[gnu::always_inline]] std::array<Bits<T>, 4> words(const Bits<T>& trial, Channel channel,
                                                      const Bits<T>& call) const {
    using B = Bits<T>;
    // 32-bit words in 64-bit lanes. What stands above a word is left to stand: the product looks at the low half only.
    B c0 = trial, c1 = trial >> 32, c2 = call, c3((std::uint64_t{study_} << 16) | static_cast<std::uint32_t>(channel));
    for (const auto& key : keys_) {
      const B p0 = multiply_low32(c0, B(0xD2511F53u)), p1 = multiply_low32(c2, B(0xCD9E8D57u));
      c0 = xor3(B(p1 >> 32), c1, B(key[0]));
      c1 = p1;
      c2 = xor3(B(p0 >> 32), c3, B(key[1]));
      c3 = p0;
    }
    const B low32(0xffffffffu);
    return {c0 & low32, c1 & low32, c2 & low32, c3 & low32};
  }

  /// Two normals from two words: k = w0 and the top 8 bits of w1 make the radius, the next two bits of w1 the signs,
  /// and its last 22 the angle in the first quadrant:
  ///   r^2 / 2 = -ln((k + 1/2) / 2^40),  theta = (j + 1/2) / 2^22 pi/2,  z = (+-r cos theta, +-r sin theta)
  /// With theta = pi/4 + phi both are r / sqrt(2) (cos phi -+ sin phi), so that no quadrant has to be chosen.
  template <class T>
  [[gnu::always_inline]] static std::pair<T, T> box_muller(const Bits<T>& w0, const Bits<T>& w1) {
    using B = Bits<T>;
    const T k = from_bits(((w0 << 8) | (w1 >> 24)) | B(0x4330000000000000u)) - (0x1p52 - 0.5);  // exact
    const T per_root2 = sqrt(minus_log_of_ratio<40>(k));
    const T phi = (small_to_double(w1 & B(0x3fffffu)) + (0.5 - 0x1p21)) * T(kPi / 2 * 0x1p-22);
    const auto [s, c] = sincos_reduced(phi);
    const B sign(0x8000000000000000u);
    const T x = per_root2 * (c - s), y = per_root2 * (c + s);
    return {from_bits(to_bits(x) ^ ((w1 << 40) & sign)), from_bits(to_bits(y) ^ ((w1 << 41) & sign))};
  }

  std::uint64_t keys_[10][2];  ///< Weyl sequence of the seed, one pair a round
  std::uint32_t study_;
};

}  // namespace surveymc
