#include "random/stream.h"

#include <Random123/philox.h>
#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "stats/moments.h"

using namespace surveymc;
using namespace surveymc::random;

namespace {
/// Four words of Random123's own Philox at our address.
std::array<std::uint32_t, 4> random123_words(std::uint64_t seed, std::uint32_t study, std::uint64_t trial,
                                             std::uint32_t channel, std::uint32_t call) {
  const r123::Philox4x32::ctr_type counter{
      {static_cast<std::uint32_t>(trial), static_cast<std::uint32_t>(trial >> 32), call, (study << 16) | channel}};
  const r123::Philox4x32::key_type key{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  const auto r = r123::Philox4x32()(counter, key);
  return {r[0], r[1], r[2], r[3]};
}
}  // namespace

TEST_CASE("The generator is Philox 4x32-10: uniforms are the words of Random123") {
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{7}, std::uint64_t{0x123456789abcdef0}})
    for (const std::uint64_t trial : {std::uint64_t{0}, std::uint64_t{12345}, std::uint64_t{0x1fffffffe}})
      for (const std::uint32_t call : {0u, 1u, 4000000000u}) {
        const auto u = Stream(seed, 3).uniforms<double>(trial, Channel::reference_field, call);
        const auto w = random123_words(seed, 3, trial, 2, call);
        for (std::size_t i = 0; i < 4; ++i) CHECK(u[i] == (w[i] + 0.5) * 0x1p-32);
      }
}

TEST_CASE("Normals are Box-Muller of those words: 39 bits of radius, two signs, 22 bits of angle") {
  // Single precision: the sum of radius, sine and cosine may be wrong by a few units of 2^-24.
  const Stream stream(42, 1);
  for (std::uint64_t trial = 0; trial < 30000; ++trial) {
    const auto w = random123_words(42, 1, trial, 0, 5);
    const auto z = stream.normals<double>(trial, Channel::magnetometer_noise, 5);
    for (std::size_t pair = 0; pair < 2; ++pair) {
      const std::uint32_t w0 = w[2 * pair], w1 = w[2 * pair + 1];
      const std::uint64_t k = (std::uint64_t{w0 >> 1} << 8) | (w1 >> 24);
      const long double radius = sqrtl(-2 * logl((static_cast<long double>(k) + 0.5L) * 0x1p-39L));
      const long double angle = acosl(0.0L) * ((w1 & 0x3fffff) + 0.5L) * 0x1p-22L;  // in the first quadrant
      const double sign0 = (w1 >> 23) & 1 ? -1 : 1, sign1 = (w1 >> 22) & 1 ? -1 : 1;
      const double bound = 4 * 0x1p-24 * static_cast<double>(radius);
      CHECK(std::abs(z[2 * pair] - sign0 * static_cast<double>(radius * cosl(angle))) < bound);
      CHECK(std::abs(z[2 * pair + 1] - sign1 * static_cast<double>(radius * sinl(angle))) < bound);
    }
  }
}

TEST_CASE("Lanes hold consecutive trials, bit for bit, also across 2^32") {
  const Stream stream(9, 2);
  for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{1000}, std::uint64_t{0xfffffffe}}) {
    const auto z = stream.normals<simd::Lanes>(simd::consecutive<simd::Lanes>(first), Channel::magnetometer_noise, 3);
    for (int i = 0; i < 4; ++i)
      for (std::uint32_t j = 0; j < 4; ++j)
        CHECK(simd::lane(z[j], i) ==
              stream.normal(first + static_cast<std::uint64_t>(i), Channel::magnetometer_noise, 12 + j));
  }
}

TEST_CASE("Draws have the moments of a standard normal and are not correlated with their neighbours", "[long]") {
  const Stream stream(20251120, 1);
  constexpr int n = 200000;
  Eigen::MatrixXd x(8, n);  // two calls, so that pairs across calls and within are seen
  for (int t = 0; t < n; ++t)
    for (std::uint32_t j = 0; j < 8; ++j)
      x(j, t) = stream.normal(static_cast<std::uint64_t>(t), Channel::magnetometer_noise, j);
  const stats::Moments m = stats::Moments::of(x.transpose());
  for (int i = 0; i < 8; ++i) {
    // 4.5 standard errors: 1, sqrt(2), sqrt(6), sqrt(24) over sqrt(n); 44 checks leave a false alarm of 3e-4
    CHECK(std::abs(m.mean[i]) < 4.5 / std::sqrt(n));
    CHECK(std::abs(m.variance(i) - 1) < 4.5 * std::sqrt(2.0 / n));
    CHECK(std::abs(m.skewness(i)) < 4.5 * std::sqrt(6.0 / n));
    CHECK(std::abs(m.kurtosis(i) - 3) < 4.5 * std::sqrt(24.0 / n));
    for (int j = 0; j < i; ++j) CHECK(std::abs(m.covariance()(i, j)) < 4.5 / std::sqrt(n));
  }
}

TEST_CASE("Tails beyond 4 sigma come as often as they should") {
  const Stream stream(5, 1);
  std::uint64_t beyond = 0;
  constexpr std::uint64_t calls = 500000;
  for (std::uint64_t t = 0; t < calls; ++t)
    for (const double z : stream.normals<double>(t, Channel::magnetometer_noise, 0)) beyond += std::abs(z) > 4;
  const double expected = 4.0 * calls * 6.334248366623996e-5;  // 2 (1 - Phi(4))
  CHECK(std::abs(static_cast<double>(beyond) - expected) < 4.5 * std::sqrt(expected));
}

TEST_CASE("Seed, study, channel and trial each change the draw") {
  const double z = Stream(1, 1).normal(0, Channel::magnetometer_noise, 0);
  CHECK(z != Stream(2, 1).normal(0, Channel::magnetometer_noise, 0));
  CHECK(z != Stream(1ull << 32, 1).normal(0, Channel::magnetometer_noise, 0));
  CHECK(z != Stream(1, 2).normal(0, Channel::magnetometer_noise, 0));
  CHECK(z != Stream(1, 1).normal(0, Channel::accelerometer_noise, 0));
  CHECK(z != Stream(1, 1).normal(1ull << 32, Channel::magnetometer_noise, 0));
}
