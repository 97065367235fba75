#include "simd/numerics_probe.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>
#include <Eigen/Dense>

namespace surveymc::simd {
namespace {

/// The product of two complex numbers. Where a compiler puts its parts into one vector it may fuse products and sums,
/// contraction off or not (GCC 12).
[[gnu::noinline]] void turned(double x, double y, double cosine, double sine, double* out) {
  out[0] = x * cosine - y * sine;
  out[1] = x * sine + y * cosine;
}

}  // namespace

std::string numerics_probe(const std::vector<double>& more) {
  // Variants of a function differ at one of some hundred to some thousand arguments.
  constexpr int kArguments = 4096;
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a over words of 64 bits
  const auto add = [&](double x) { hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 1099511628211u; };
  for (int i = 1; i <= kArguments; ++i) {
    const volatile double argument = 0.0031 * i + 1e-7 * i * i;  // volatile: computed here and not by the compiler
    const double x = argument, small = x / 16;
    for (const double y : {std::sin(x),          std::cos(x),          std::tan(x),      std::exp(x),      std::log(x),
                           std::pow(x, 1.7),     std::sqrt(x),         std::asin(small), std::acos(small), std::atan(x),
                           std::atan2(small, x), std::hypot(small, x), std::sinh(x),     std::cosh(x),     std::tanh(x),
                           std::expm1(small),    std::log1p(small),    std::cbrt(x),     std::erf(x),      std::erfc(x),
                           std::tgamma(x),       std::lgamma(x),       std::fmod(x, 0.3)})
      add(y);
    double parts[2];
    turned(x, small, argument / 7, 1 / x, parts);
    for (const double y : parts) add(y);
  }
  constexpr Eigen::Index kRows = 37, kInner = 29, kColumns = 11;  // no multiples of any vector's length
  const auto matrix = [](Eigen::Index rows, Eigen::Index columns) {
    Eigen::MatrixXd m(rows, columns);
    for (Eigen::Index c = 0; c < columns; ++c)
      for (Eigen::Index r = 0; r < rows; ++r) m(r, c) = 1.0 / static_cast<double>(3 + 7 * r + 5 * c);
    return m;
  };
  const Eigen::MatrixXd a = matrix(kRows, kInner), b = matrix(kInner, kColumns), product = a * b;
  for (const double y : product.reshaped()) add(y);
  add(a.sum());
  add(a.col(0).dot(a.col(1)));
  add(a.col(2).norm());
  for (const double y : more) add(y);
  return fmt::format("{:08x}", static_cast<std::uint32_t>(hash ^ (hash >> 32)));
}

void fix_block_sizes() {
  constexpr std::ptrdiff_t kFirst = 32 << 10, kSecond = 512 << 10, kThird = 32 << 20;
  Eigen::setCpuCacheSizes(kFirst, kSecond, kThird);
}

}  // namespace surveymc::simd
