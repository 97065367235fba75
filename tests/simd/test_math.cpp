#include "simd/math.h"

#include <random>

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::simd;

namespace {
// An oracle with more digits: x87 long double.
double ulps(double x, long double exact) {
  const double rounded = static_cast<double>(exact);
  const double ulp = std::nextafter(std::abs(rounded), 1e308) - std::abs(rounded);
  return std::abs(static_cast<double>(static_cast<long double>(x) - exact)) / ulp;
}
}  // namespace

TEST_CASE("log is right to 1 ulp from the smallest uniform draw to large numbers") {
  std::mt19937_64 g(1);
  std::uniform_real_distribution<double> exponent(-700, 700), near_one(0.5, 2);
  for (int i = 0; i < 200000; ++i) {
    const double far = std::exp(exponent(g)), near = near_one(g);
    REQUIRE(ulps(surveymc::simd::log(far), logl(far)) <= 1.0);
    REQUIRE(ulps(surveymc::simd::log(near), logl(near)) <= 1.0);
  }
  CHECK(surveymc::simd::log(1.0) == 0);
  CHECK(ulps(surveymc::simd::log(0x1p-41), logl(0x1p-41L)) <= 1.0);
}

TEST_CASE("sin and cos are right to 3e-16 up to 1e5 rad, and exact where they should be") {
  std::mt19937_64 g(2);
  std::uniform_real_distribution<double> x(-1e5, 1e5);
  for (int i = 0; i < 200000; ++i) {
    const double a = x(g);
    const auto [s, c] = surveymc::simd::sincos(a);
    REQUIRE(std::abs(s - static_cast<double>(sinl(a))) < 3e-16);
    REQUIRE(std::abs(c - static_cast<double>(cosl(a))) < 3e-16);
  }
  CHECK(surveymc::simd::sincos(0.0).first == 0);
  CHECK(surveymc::simd::sincos(0.0).second == 1);
  CHECK(surveymc::simd::sincos(1e-9).first == 1e-9);
}

TEST_CASE("asin(x)/x is right to 3e-16 up to x = 1/2") {
  std::mt19937_64 g(3);
  std::uniform_real_distribution<double> x(1e-9, 0.5);
  for (int i = 0; i < 200000; ++i) {
    const double a = x(g), z = a * a;
    REQUIRE(std::abs(asin_ratio(z) - static_cast<double>(asinl(sqrtl(z)) / sqrtl(z))) < 3e-16);
  }
  CHECK(asin_ratio(0.0) == 1);
}

TEST_CASE("exp is right to 1 ulp, 0 where no normal number is, and undone by log") {
  std::mt19937_64 g(5);
  std::uniform_real_distribution<double> far(-708, 709), near_zero(-1, 1);
  for (int i = 0; i < 200000; ++i) {
    const double a = far(g), b = near_zero(g);
    REQUIRE(ulps(surveymc::simd::exp(a), expl(a)) <= 1.0);
    REQUIRE(ulps(surveymc::simd::exp(b), expl(b)) <= 1.0);
    REQUIRE(std::abs(surveymc::simd::log(surveymc::simd::exp(b)) - b) <
            4e-16);  // 1 ulp of e^b is 2.2e-16 relative, and log's own
  }
  CHECK(surveymc::simd::exp(0.0) == 1);
  CHECK(surveymc::simd::exp(-0.0) == 1);
  CHECK(surveymc::simd::exp(-708.0) > 2.3e-308);  // the smallest normal number is 2.23e-308
  CHECK(surveymc::simd::exp(-708.1) == 0);
  CHECK(surveymc::simd::exp(-1e300) == 0);
}

TEST_CASE("A lane gives the bits of the scalar") {
  std::mt19937_64 g(4);
  std::uniform_real_distribution<double> x(-1e4, 1e4), positive(1e-12, 1e3), small(0, 0.25);
  for (int i = 0; i < 20000; ++i) {
    double a[4], b[4], c[4], d[4];
    for (int k = 0; k < 4; ++k) {
      a[k] = x(g);
      b[k] = positive(g);
      c[k] = small(g);
      d[k] = 0.1 * a[k] - 300;  // some of them below -708
    }
    const auto sc = surveymc::simd::sincos(load<Lanes>(a));
    const Lanes l = surveymc::simd::log(load<Lanes>(b)), r = asin_ratio(load<Lanes>(c)),
                e = surveymc::simd::exp(load<Lanes>(d));
    for (int k = 0; k < 4; ++k) {
      REQUIRE(lane(sc.first, k) == surveymc::simd::sincos(a[k]).first);
      REQUIRE(lane(sc.second, k) == surveymc::simd::sincos(a[k]).second);
      REQUIRE(lane(l, k) == surveymc::simd::log(b[k]));
      REQUIRE(lane(r, k) == asin_ratio(c[k]));
      REQUIRE(lane(e, k) == surveymc::simd::exp(d[k]));
    }
  }
}
