#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "base/units.h"
#include "reliability/significance.h"

using namespace surveymc;
using namespace surveymc::reliability;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("lambda0 of the paper's levels, alpha per tail and for both") {
  CHECK_THAT(lambda0({1e-4, Tails::one, 0.8}), WithinAbs(4.560637719029, 1e-12));
  CHECK_THAT(lambda0({2.5e-4, Tails::one, 0.8}), WithinAbs(4.322377637919, 1e-12));
  CHECK_THAT(lambda0({1e-4, Tails::two, 0.8}), WithinAbs(4.732213119986, 1e-12));
  CHECK_THAT(lambda0({2.5e-4, Tails::two, 0.8}), WithinAbs(4.503881164461, 1e-12));
}

TEST_CASE("An error of lambda0 is detected with the power, and none with alpha") {
  const TestLevels levels{1e-3, Tails::one, 0.9};
  CHECK_THAT(w_power(lambda0(levels), w_critical(levels)), WithinAbs(0.9, 1e-12));
  CHECK_THAT(w_power(0, w_critical(levels)), WithinRel(2e-3, 1e-10));
  CHECK_THAT(w_p_value(w_critical(levels)), WithinRel(2e-3, 1e-10));
}

TEST_CASE("B-method: levels of two- and three-dimensional tests of equal power") {
  const double square = std::pow(lambda0({1e-4, Tails::one, 0.8}), 2);
  CHECK_THAT(square, WithinAbs(20.7994, 5e-5));
  CHECK_THAT(b_method_level(1, square, 0.8).alpha, WithinAbs(2.0e-4, 5e-8));
  CHECK_THAT(b_method_level(2, square, 0.8).alpha, WithinAbs(6.29e-4, 5e-7));
  CHECK_THAT(b_method_level(3, square, 0.8).alpha, WithinAbs(1.335e-3, 5e-7));
}

TEST_CASE("tau2 and Pope's tau follow from F and t by the paper's relations") {
  // One dimension: Pope's tau squared is tau2 (eq 6 with r = 1), t squared is F(1, n-u-1).
  for (const double redundancy : {3.0, 9.0, 60.0})
    CHECK_THAT(std::pow(pope_critical(redundancy, 1e-3), 2),
               WithinRel(tau_squared_critical(1, redundancy, 1e-3), 1e-9));
  CHECK(pope_critical(3, 1e-9) < std::sqrt(3.0));  // bounded by the root of the redundancy
  CHECK(std::isinf(fisher_critical(3, 3, 0.01)));
  CHECK(std::isinf(tau_squared_critical(3, 3, 0.01)));
  CHECK(std::isinf(pope_critical(1, 0.01)));
  CHECK_THAT(chi_squared_p_value(2, chi_squared_critical(2, 0.01)), WithinRel(0.01, 1e-10));
  // P(F > x) = (1 + 2 x / n)^(-n/2) with 2 and n degrees of freedom
  CHECK_THAT(fisher_critical(2, 9, 0.01), WithinRel(3.5 * (std::pow(0.01, -2.0 / 7) - 1), 1e-9));
}

TEST_CASE("A test statistic that is no number has no p-value") {
  CHECK(std::isnan(chi_squared_p_value(2, kNaN)));
  CHECK(std::isnan(w_p_value(kNaN)));
  CHECK(chi_squared_p_value(2, kInfinity) == 0);
}

TEST_CASE("Shift that tells two correlated tests apart") {
  for (const double rho : {0.0, 0.3, -0.9, 0.999})
    CHECK_THAT(identification_probability(identifiable_shift(rho, 0.8), rho), WithinAbs(0.8, 1e-10));
  CHECK(identifiable_shift(0.9, 0.8) == identifiable_shift(-0.9, 0.8));
  CHECK(identifiable_shift(0.9, 0.8) > identifiable_shift(0.5, 0.8));
  CHECK(std::isinf(identifiable_shift(1, 0.8)));
  CHECK(std::isinf(identifiable_shift(-1, 0.8)));
  CHECK(identifiable_shift(0.5, 0.5) == 0);
  CHECK(std::isinf(identifiable_shift(1, 0.5)));
  CHECK(std::isinf(identifiable_shift(-1, 0.3)));
  CHECK_THAT(identification_probability(0, 0.4), WithinAbs(0.5, 1e-15));
}

TEST_CASE("Probabilities of tests are probabilities, for errors of any size") {
  // Each is a sum of at most two tails that a library gives to its rounding: an epsilon each beyond [0, 1], not more.
  const double slack = 2 * std::numeric_limits<double>::epsilon();
  const auto check = [&](double p) {
    CHECK(p >= -slack);
    CHECK(p <= 1 + slack);
  };
  for (const double size : {0.0, 1e-8, 0.5, 3.0, 10.0, 37.0, 100.0})
    for (const double critical : {1e-3, 1.0, 3.29, 6.0}) {
      check(w_power(size, critical));
      check(chi_squared_power(3, size * size, critical * critical));
      check(chi_squared_power(60, size * size, critical * critical));
      for (const double rho : {0.0, 0.5, 1 - 1e-9, 1.0}) check(identification_probability(size, rho));
    }
  for (const double size : {0.0, 0.5, 3.0, 10.0, 30.0})
    for (const double redundancy : {2.0, 3.0, 30.0, 1e4})
      for (const double alpha : {1e-6, 1e-3, 0.5}) check(pope_power(size, redundancy, alpha));
}
