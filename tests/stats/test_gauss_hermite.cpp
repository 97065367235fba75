#include "stats/gauss_hermite.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace surveymc::stats;

TEST_CASE("Gauss-Hermite quadrature gives the moments of the standard normal") {
  const GaussHermite q = gauss_hermite(41);
  REQUIRE(q.nodes.size() == 41);
  double expected = 1;  // E z^(2 m) = 1 3 5 ... (2 m - 1)
  for (int m = 0; m <= 20; ++m) {
    double even = 0, odd = 0;
    for (std::size_t i = 0; i < q.nodes.size(); ++i) {
      even += q.weights[i] * std::pow(q.nodes[i], 2 * m);
      odd += q.weights[i] * std::pow(q.nodes[i], 2 * m + 1);
    }
    CHECK(std::abs(even / expected - 1) < 1e-12 * (m + 1));
    CHECK(std::abs(odd) < 1e-12 * expected * (m + 1));
    expected *= 2 * m + 1;
  }
  CHECK(gauss_hermite(3).nodes[2] == Approx(std::sqrt(3.0)).epsilon(1e-15));
}
