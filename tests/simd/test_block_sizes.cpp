#include <cmath>
#include <vector>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "simd/numerics_probe.h"

using namespace surveymc;

TEST_CASE("Large products have the same bits whatever caches the processor has") {
  constexpr Eigen::Index kInner = 1000;
  Eigen::MatrixXd a(30, kInner), b(kInner, 30);
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    a(i) = 1.0 / static_cast<double>(3 + 7 * i);
    b(i) = 1.0 / static_cast<double>(5 + 3 * i);
  }
  const auto product_with = [&](std::ptrdiff_t first_cache, bool fixed) {
    Eigen::setCpuCacheSizes(first_cache, 1 << 20, 32 << 20);
    if (fixed) simd::fix_block_sizes();
    return Eigen::MatrixXd(a * b);
  };
  const Eigen::MatrixXd here = product_with(32 << 10, true);
  for (const std::ptrdiff_t kilobytes : {16, 48, 64, 128}) CHECK(product_with(kilobytes << 10, true) == here);
  CHECK(product_with(48 << 10, false) != here);  // so the test sees it
  simd::fix_block_sizes();
}

TEST_CASE("The probe of numerics sees the last bit of what other libraries compute") {
  const std::vector<double> values{1.0, 0.1, 1e-9}, other{1.0, 0.1, std::nextafter(1e-9, 1.0)};
  CHECK(simd::numerics_probe(values) == simd::numerics_probe(values));
  CHECK(simd::numerics_probe(values) != simd::numerics_probe(other));
  CHECK(simd::numerics_probe(values) != simd::numerics_probe());
}
