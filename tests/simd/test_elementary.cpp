#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include <catch2/catch.hpp>

// Elementary functions of third_party/elementary, which take the names of the C library's. Those of long double are
// still the C library's, and are the oracle.

namespace {

struct Function {
  const char* name;
  double (*own)(double);
  long double (*oracle)(long double);
  double from, to;
  double ulps;  ///< bound of the error; tgamma, a sum of twelve terms, has 5.4
};

double ulps_between(double x, long double exact) {
  int exponent = 0;
  std::frexp(static_cast<double>(exact), &exponent);
  const long double ulp = std::ldexp(1.0L, std::max(exponent - 53, -1074));
  return static_cast<double>(std::abs(static_cast<long double>(x) - exact) / ulp);
}

const Function kFunctions[] = {{"sin", std::sin, std::sin, -100, 100, 1},
                               {"cos", std::cos, std::cos, -100, 100, 1},
                               {"tan", std::tan, std::tan, -100, 100, 1},
                               {"asin", std::asin, std::asin, -1, 1, 1},
                               {"acos", std::acos, std::acos, -1, 1, 1},
                               {"atan", std::atan, std::atan, -50, 50, 1},
                               {"exp", std::exp, std::exp, -700, 700, 1},
                               {"exp2", std::exp2, std::exp2, -1000, 1000, 1},
                               {"expm1", std::expm1, std::expm1, -30, 30, 1},
                               {"log", std::log, std::log, 1e-9, 10, 1},
                               {"log2", std::log2, std::log2, 1e-9, 10, 1},
                               {"log10", std::log10, std::log10, 1e-9, 10, 1.5},
                               {"log1p", std::log1p, std::log1p, -0.999, 10, 1},
                               {"sinh", std::sinh, std::sinh, -20, 20, 2},
                               {"cosh", std::cosh, std::cosh, -20, 20, 2},
                               {"tanh", std::tanh, std::tanh, -20, 20, 2.5},
                               {"asinh", std::asinh, std::asinh, -20, 20, 2},
                               {"acosh", std::acosh, std::acosh, 1, 20, 2},
                               {"atanh", std::atanh, std::atanh, -0.999, 0.999, 2},
                               {"cbrt", std::cbrt, std::cbrt, -50, 50, 1},
                               {"erf", std::erf, std::erf, -6, 6, 1},
                               {"erfc", std::erfc, std::erfc, -5, 25, 2},
                               {"tgamma", std::tgamma, std::tgamma, 0.1, 50, 8},
                               {"lgamma", std::lgamma, std::lgamma, 3, 100, 2}};

constexpr int kArguments = 4000;

double argument(const Function& f, int i) {
  const volatile double share =
      (i + 0.4142135623730951) / kArguments;  // volatile: no value is computed by the compiler
  return f.from + (f.to - f.from) * share;
}

}  // namespace

TEST_CASE("Elementary functions are right to about one unit in the last place") {
  for (const Function& f : kFunctions) {
    double worst = 0;
    for (int i = 0; i < kArguments; ++i) {
      const double x = argument(f, i);
      worst = std::max(worst, ulps_between(f.own(x), f.oracle(x)));
    }
    CAPTURE(f.name, worst);
    CHECK(worst < f.ulps);
    CHECK(worst > 0.4);  // half a unit is the least that rounding leaves over so many arguments
  }
}

TEST_CASE("Elementary functions have the same bits on every machine, with every C library") {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a over words of 64 bits
  const auto add = [&](double x) { hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 1099511628211u; };
  for (const Function& f : kFunctions)
    for (int i = 0; i < kArguments; ++i) add(f.own(argument(f, i)));
  for (int i = 0; i < kArguments; ++i) {
    const double x = argument(kFunctions[9], i);
    add(std::pow(x, 1.7));
    add(std::hypot(x, 0.3));
    add(std::atan2(x - 5, 0.7));
  }
  CHECK(hash == 0x28152cf2e95c5993u);
}
