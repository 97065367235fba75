#pragma once
/// Random numbers that are addressed by their purpose.
///
/// A draw is a pure function of (seed, study, trial, channel, index): not of thread, block, lane or earlier draws. Two
/// estimators on one seed see the same noise, and any single trial can be replayed.
///
/// Philox 4x32-10 (Salmon et al., SC'11; the tests compare it with Random123) gives four 32-bit words for each counter
///   (trial low, trial high, index / 4, study << 16 | channel), key = (seed low, seed high).
/// Two words make two normals (Box-Muller): 39 bits for the radius, which reaches 7.4 sigma, and 24 for the direction.
/// Normals are computed in single precision: each is accurate to 2.4e-7 of its pair's radius (a test), far below what
/// any number of trials can resolve; everything computed from them is double.
#include <array>
#include <cstdint>

#include "base/units.h"
#include "simd/singles.h"

namespace surveymc::random {

using namespace simd;

/// The purpose of a draw. The numbers are part of every archived result: new channels go at the end.
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
  chained_state = 40,        ///< index 9 station + state: first values and steps of a chain (sensor/chained_runs.h)
  chained_noise = 41,        ///< index 6 station + {accelerometer x, y, z, magnetometer x, y, z}
  chained_toolface = 42,     ///< index station: uniform
  chained_profile = 43,      ///< index {0, 1}: uniform; what a study draws of the profile
  axial_magnetisation = 50,  ///< index station: of the string, new at every station (axial_correction)
  station_reference = 51,    ///< index 4 station + {gravity, horizontal field, vertical field} (axial_correction)
  error_source = 60,         ///< error models: draws of several stations (propagate/well_errors.h), in their order
  station_error = 61,        ///< error models: draws of one station, in their order; 62, 70 .. 74: rare_channels.h
  disturbed_run = 80,  ///< index as in survey/sensor_terms.h, 12 interference, 13 total field, 14 dip, 15 declination
  disturbed_station = 81,  ///< index 4 station + {total field, dip, declination} (sensor/disturbed_runs.h)
  gross_choice = 90,       ///< index: which stations are wrong, one uniform a place (sensor/gross_stations.h)
  gross_size = 91,         ///< index 4 station + axis; of an error that stations share, station 0
  robust_subset = 92,      ///< index of a place in the subsets of lmeds (multistation/subsets.h)
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
    const auto [x, y] = box_muller<T>(join(w[0], w[2]), join(w[1], w[3]));
    return {lower(x), lower(y), upper(x), upper(y)};
  }
  /// Four uniforms in (0, 1), the same indices.
  template <class T>
  [[gnu::always_inline]] std::array<T, 4> uniforms(const Bits<T>& trial, Channel channel, const Bits<T>& call) const {
    const auto w = words<T>(trial, channel, call);
    const Bits<T> low32(0xffffffffu);
    std::array<T, 4> u;
    for (std::size_t i = 0; i < 4; ++i) u[i] = fma(small_to_double(w[i] & low32), T(0x1p-32), T(0x1p-33));
    return u;
  }
  /// One standard normal by its address: the readable definition.
  double normal(std::uint64_t trial, Channel channel, std::uint32_t index) const {
    return normals<double>(trial, channel, std::uint64_t{index / 4})[index % 4];
  }

 private:
  /// The low halves of the lanes; the bits above them are not part of the draw.
  template <class T>
  [[gnu::always_inline]] std::array<Bits<T>, 4> words(const Bits<T>& trial, Channel channel,
                                                      const Bits<T>& call) const {
    using B = Bits<T>;
    // 32-bit words in 64-bit lanes. The bits above a word may be anything: the product reads the low half only.
    B c0 = trial, c1 = trial >> 32, c2 = call, c3((std::uint64_t{study_} << 16) | static_cast<std::uint32_t>(channel));
    for (const auto& key : keys_) {
      const B p0 = multiply_low32(c0, B(0xD2511F53u)), p1 = multiply_low32(c2, B(0xCD9E8D57u));
      c0 = xor3(B(p1 >> 32), c1, B(key[0]));
      c1 = p1;
      c2 = xor3(B(p0 >> 32), c3, B(key[1]));
      c3 = p0;
    }
    return {c0, c1, c2, c3};
  }

  /// Two normals from two words, r and a, in single precision. The upper 31 bits of r and the top 8 bits of a make the
  /// radius, the next two bits of a the signs, and its last 22 the angle in the first quadrant:
  ///   rho^2 = -ln((k + 1/2) / 2^39),  theta = (j + 1/2) / 2^22 pi/2,  z = (+-sqrt(2) rho cos theta, +-.. sin theta)
  /// With theta = pi/4 + phi both are rho (cos phi -+ sin phi), so that no quadrant has to be chosen.
  template <class T, class W = typename SinglesOf<T>::words, class S = typename SinglesOf<T>::type>
  [[gnu::always_inline]] static std::pair<S, S> box_muller(const W& r, const W& a) {
    const W upper31 = r >> 1;
    const S last8 = nearest_single(a >> 24);
    const S u = fma(nearest_single(upper31), S(0x1p-31f), fma(last8, S(0x1p-39f), S(0x1p-40f)));
    const S u_less_1 =
        fma(nearest_single(upper31 ^ W(0x7fffffffu)), S(-0x1p-31f), fma(last8, S(0x1p-39f), S(-0x1.ffp-32f)));
    const S rho = sqrt(minus_log<W, S>(u, u_less_1));
    const S phi = (nearest_single(a & W(0x3fffffu)) + S(0.5f - 0x1p21f)) * S(static_cast<float>(kPi / 2 * 0x1p-22));
    const auto [s, c] = sincos_single(phi);
    const W sign(0x80000000u);
    const S x = rho * (c - s), y = rho * (c + s);
    return {from_words(to_words(x) ^ ((a << 8) & sign)), from_words(to_words(y) ^ ((a << 9) & sign))};
  }

  std::uint64_t keys_[10][2];  ///< Weyl sequence of the seed, one pair a round
  std::uint32_t study_;
};

}  // namespace surveymc::random
