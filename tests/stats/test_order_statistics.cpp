#include "stats/order_statistics.h"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::stats;

TEST_CASE("A quantile is the smallest value with its share at or below it", "[stats]") {
  const std::vector<double> x{1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  CHECK(sorted_quantile(x, 0.5) == 5);
  CHECK(sorted_quantile(x, 0.51) == 6);
  CHECK(sorted_quantile(x, 0.05) == 1);
  CHECK(sorted_quantile(x, 1) == 10);
  CHECK(sorted_quantile({7}, 0.5) == 7);
}

TEST_CASE("A median is the middle value, or the mean of the two middle ones", "[stats]") {
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({4, 1, 3, 2}) == 2.5);
  CHECK(median({7}) == 7);
  CHECK(median({1, infinity, 2}) == 2);
  CHECK(median({1, infinity, infinity, 2}) == infinity);
  CHECK(std::isnan(median({})));
}

TEST_CASE("The interval of a median is that of the binomial table", "[stats]") {
  std::vector<double> x;
  for (int i = 1; i <= 10; ++i) x.push_back(i);
  // n = 10: P(B <= 1) = 11 / 1024 = 0.0107 <= 0.025 < P(B <= 2) = 0.0547: the 2nd and the 9th value.
  CHECK(median_interval(x, 0.95).lo == 2);
  CHECK(median_interval(x, 0.95).hi == 9);
  CHECK(std::isinf(median_interval({1, 2, 3, 4, 5}, 0.95).hi));  // 2 / 32 > 0.05: no interval of five values
  x.clear();
  for (int i = 1; i <= 4000; ++i) x.push_back(i);  // 2^-4000 is no double
  // Normal approximation: 2000 -+ 1.96 sqrt(4000) / 2 = 2000 -+ 62.
  CHECK(std::abs(median_interval(x, 0.95).lo - 1938) <= 2);
  CHECK(std::abs(median_interval(x, 0.95).hi - 2063) <= 2);
}
