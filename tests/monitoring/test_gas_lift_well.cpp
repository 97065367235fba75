#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "monitoring/gas_lift_well.h"

using namespace surveymc;
using namespace surveymc::monitoring;
using Catch::Matchers::WithinAbs;

/// Of the eigenvalues of a matrix: the roots of its characteristic polynomial, all at once (Durand and Kerner).
static double largest_real_part(const Eigen::Matrix3d& a) {
  const double unit = a.norm(), trace = a.trace() / unit, det = a.determinant() / std::pow(unit, 3);
  const double minors = (trace * trace - (a * a).trace() / (unit * unit)) / 2;
  std::array<std::complex<double>, 3> r{1.0, {.4, .9}, {-.65, .72}};
  for (int i = 0; i < 200; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto p = ((r[k] - trace) * r[k] + minors) * r[k] - det;
      r[k] -= p / ((r[k] - r[(k + 1) % 3]) * (r[k] - r[(k + 2) % 3]));
    }
  return unit * std::max({r[0].real(), r[1].real(), r[2].real()});
}

TEST_CASE("Steady states of the gas-lift well to the printed digits, and which of them are stable", "[monitoring]") {
  struct Case {
    double w, pwf, pwh, pat, ptm, eigenvalue;
  };
  const GasLiftWell well;
  for (const Case& c : {Case{.20, 13946.806, 1621.344, 11281.861, 11411.385, 2.2e-4},
                        Case{.40, 13260.165, 2022.354, 11329.040, 11828.850, -6.0e-4},
                        Case{.60, 12960.507, 2326.568, 12014.866, 13035.352, -6.0e-4}}) {
    const GasLiftState x = gas_lift_steady_state(well, c.w);
    const GasLiftPressures p = gas_lift_pressures(well, x, c.w);
    CHECK_THAT(p.pt_f / 1000, WithinAbs(c.pwf, 5e-4));
    CHECK_THAT(p.pt_t / 1000, WithinAbs(c.pwh, 5e-4));
    CHECK_THAT(p.pt_g / 1000, WithinAbs(c.pat, 5e-4));
    CHECK_THAT(p.pt_m / 1000, WithinAbs(c.ptm, 5e-4));
    CHECK_THAT(largest_real_part(gas_lift_jacobian(well, x, c.w)), WithinAbs(c.eigenvalue, 5e-6));
    // Mass flows are kg/s: what is left is rounding of 10 kg/s.
    for (const double d : gas_lift_derivative(well, x, c.w)) CHECK_THAT(d, WithinAbs(0, 1e-12));
  }
  CHECK_THROWS_AS(gas_lift_steady_state(well, 0), InputError);
}

TEST_CASE("A Runge-Kutta step has a local error of fifth order", "[monitoring]") {
  const GasLiftWell well;
  GasLiftState x = gas_lift_steady_state(well, .5);
  const auto end = [&](int steps) {
    GasLiftState y = x;
    for (int i = 0; i < steps; ++i) y = gas_lift_step(well, y, .8, 320.0 / steps);
    return y[1];
  };
  const double reference = end(640);
  const double ratio = (end(8) - reference) / (end(16) - reference);
  CHECK(ratio > 12);  // 2^4 = 16 in the limit
  CHECK(ratio < 20);
}

TEST_CASE("The simulation starts at rest and comes to rest at each stable rate", "[monitoring]") {
  const GasLiftWell well;
  const Samples p = simulate_gas_lift(well, {7.5, {.6, .8}}, 60, 5);
  REQUIRE(p.rows() == 900);
  CHECK((p.row(449) - p.row(0)).cwiseAbs().maxCoeff() < 1e-3);  // Pa, of 1e7
  const GasLiftPressures rest = gas_lift_pressures(well, gas_lift_steady_state(well, .8), .8);
  CHECK_THAT(p(899, 0), WithinAbs(rest.pt_f, 50));  // 7.5 h are 16 time constants: e^-16 of 1e5 Pa, with oscillation
  CHECK(p(450, 3) > p(449, 3) + 1e5);               // upstream of the choke the pressure follows the rate at once
  CHECK_THAT(p(450, 2), WithinAbs(p(449, 2), 1));
}

TEST_CASE("The schedule trains in range, and leaves it only on request", "[monitoring]") {
  const auto in = gas_lift_schedule(false), out = gas_lift_schedule(true);
  REQUIRE(in.rates.size() == 30);
  CHECK(*std::min_element(in.rates.begin(), in.rates.end()) == .40);
  CHECK(*std::max_element(in.rates.begin(), in.rates.end()) == .90);
  CHECK(std::equal(in.rates.begin(), in.rates.begin() + 24, out.rates.begin()));
  CHECK(*std::min_element(out.rates.end() - 6, out.rates.end()) == .92);
  CHECK(*std::max_element(out.rates.end() - 6, out.rates.end()) == 1.10);
}
