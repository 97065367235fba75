#include "simd/singles.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::simd;

namespace {
using S = Singles<2>;
using W = Words32<2>;
constexpr double kUnit = 0x1p-24;  ///< half a unit in the last place of 1
}  // namespace

TEST_CASE("Logarithm in single precision: relative error over all magnitudes and up to one", "[singles]") {
  double worst = 0;
  const auto check = [&](float u, double u_less_1) {
    const double exact = u_less_1 > -0.29 ? -std::log1p(u_less_1) : -std::log(static_cast<double>(u));
    const double value = lower(minus_log<W, S>(S(u), S(static_cast<float>(u_less_1))));
    worst = std::max(worst, std::abs(value / exact - 1));
  };
  for (std::uint32_t bits = __builtin_bit_cast(std::uint32_t, 0x1p-40f); bits < 0x3f800000u; bits += 977) {
    const float u = __builtin_bit_cast(float, bits);
    check(u, static_cast<double>(u) - 1);
  }
  for (double v = 0x1p-40; v < 0.29; v *= 1.001)
    check(static_cast<float>(1 - v), -static_cast<double>(static_cast<float>(v)));
  CHECK(worst < 3.5 * kUnit);
  CHECK(lower(minus_log<W, S>(S(1.0f), S(0.0f))) == 0);
}

TEST_CASE("Sine and cosine in single precision", "[singles]") {
  double worst = 0;
  for (int i = -100000; i <= 100000; ++i) {
    const float x = static_cast<float>(i) * static_cast<float>(M_PI / 4e5);
    const auto [s, c] = sincos_single(S(x));
    worst = std::max({worst, std::abs(lower(s) - std::sin(static_cast<double>(x))),
                      std::abs(upper(c) - std::cos(static_cast<double>(x)))});
  }
  CHECK(worst < 1.5 * kUnit);
}

TEST_CASE("Singles lie in the place of doubles, lane by lane and in a Pack", "[singles]") {
  using Two = Pack<Lanes, 2>;
  std::uint64_t a[16], b[16];
  for (std::uint64_t i = 0; i < 16; ++i) {
    a[i] = 0x9e3779b97f4a7c15u * (i + 1);
    b[i] = 0xbf58476d1ce4e5b9u * (i + 3);
  }
  Bits<Two> packed_a, packed_b;
  constexpr int n = lane_count<Lanes>;
  for (int p = 0; p < 2; ++p)
    for (int i = 0; i < n; ++i) {
      packed_a.v[p].v[i] = a[n * p + i];
      packed_b.v[p].v[i] = b[n * p + i];
    }
  const auto words = join(packed_a, packed_b) >> 8;
  const auto x = fma(nearest_single(words), sqrt(nearest_single(words)), nearest_single(words));
  const auto y = select_from(words, 0x00800000u, x, nearest_single(words));
  for (int p = 0; p < 2; ++p)
    for (int i = 0; i < n; ++i) {
      const std::uint64_t at[2] = {a[n * p + i], b[n * p + i]};
      for (int half = 0; half < 2; ++half) {
        const std::uint32_t word = static_cast<std::uint32_t>(at[half]) >> 8;
        const float single = static_cast<float>(word);
        const float expected = word >= 0x00800000u ? std::fma(single, std::sqrt(single), single) : single;
        CHECK(lane(half == 0 ? lower(y).v[p] : upper(y).v[p], i) == static_cast<double>(expected));
      }
      const auto scalar = join(at[0], at[1]) >> 8;
      CHECK(lower(nearest_single(scalar)) == static_cast<double>(static_cast<std::uint32_t>(at[0]) >> 8));
    }
}
