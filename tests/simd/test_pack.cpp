#include "simd/pack.h"

#include <catch2/catch.hpp>

#include "random/stream.h"

using namespace surveymc;
using namespace surveymc::simd;

TEST_CASE("Calls side by side have the bits of one call after the other") {
  const random::Stream stream(7, 1);
  using Calls = Pack<Lanes, 4>;
  const Bits<Lanes> trial = consecutive<Lanes>(40);
  for (const std::uint64_t first : {0u, 36u, 4000u}) {
    const auto calls = Bits<Calls>::each([&](std::size_t j) { return Bits<Lanes>(first + j); });
    const auto normals = stream.normals<Calls>(trial, random::Channel::accelerometer_noise, calls);
    const auto uniforms = stream.uniforms<Calls>(trial, random::Channel::accelerometer_noise, calls);
    for (std::size_t j = 0; j < 4; ++j)
      for (int t = 0; t < lane_count<Lanes>; ++t) {
        const std::uint64_t number = 40 + static_cast<std::uint64_t>(t);
        const auto z = stream.normals<double>(number, random::Channel::accelerometer_noise, first + j);
        const auto u = stream.uniforms<double>(number, random::Channel::accelerometer_noise, first + j);
        for (std::size_t i = 0; i < 4; ++i) {
          REQUIRE(lane(normals[i].v[j], t) == z[i]);
          REQUIRE(lane(uniforms[i].v[j], t) == u[i]);
        }
      }
  }
}

TEST_CASE("A Pack does to each element what its type does") {
  using P = Pack<double, 3>;
  const P a = P::each([](std::size_t i) { return 0.3 + static_cast<double>(i); });
  const P b = P::each([](std::size_t i) { return 2.5 - static_cast<double>(i); });
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK((a + b).v[i] == a.v[i] + b.v[i]);
    CHECK((a - b).v[i] == a.v[i] - b.v[i]);
    CHECK((a * b).v[i] == a.v[i] * b.v[i]);
    CHECK((a / b).v[i] == a.v[i] / b.v[i]);
    CHECK((a + 1.0).v[i] == a.v[i] + 1.0);
    CHECK(fma(a, b, P(0.1)).v[i] == surveymc::simd::fma(a.v[i], b.v[i], 0.1));
    CHECK(sqrt(a).v[i] == surveymc::simd::sqrt(a.v[i]));
    CHECK(abs(P(0.0) - a).v[i] == a.v[i]);
    CHECK(from_bits(to_bits(a)).v[i] == a.v[i]);
    CHECK((to_bits(a) ^ to_bits(b)).v[i] == (to_bits(a.v[i]) ^ to_bits(b.v[i])));
    CHECK(xor3(to_bits(a), to_bits(b), to_bits(a)).v[i] == to_bits(b.v[i]));
    CHECK((to_bits(a) >> 7).v[i] == to_bits(a.v[i]) >> 7);
  }
}
