#include "simd/libm_fingerprint.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

namespace surveymc::simd {

std::string libm_fingerprint() {
  constexpr int kArguments = 128;
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a over words of 64 bits
  const auto add = [&](double x) { hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 1099511628211u; };
  for (int i = 1; i <= kArguments; ++i) {
    const volatile double argument = 0.0317 * i + 1e-5 * i * i;  // volatile: computed here and not by the compiler
    const double x = argument, small = x / 8;
    for (const double y : {std::sin(x),          std::cos(x),          std::tan(x),      std::exp(x),      std::log(x),
                           std::pow(x, 1.7),     std::sqrt(x),         std::asin(small), std::acos(small), std::atan(x),
                           std::atan2(small, x), std::hypot(small, x), std::sinh(x),     std::cosh(x),     std::tanh(x),
                           std::expm1(small),    std::log1p(small),    std::cbrt(x),     std::erf(x),      std::erfc(x),
                           std::tgamma(x),       std::lgamma(x),       std::fmod(x, 0.3)})
      add(y);
  }
  return fmt::format("{:08x}", static_cast<std::uint32_t>(hash ^ (hash >> 32)));
}

}  // namespace surveymc::simd
