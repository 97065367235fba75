#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "stats/order_statistics.h"
#include "stats/size_counts.h"

using namespace surveymc;
using stats::SizeCounts;

namespace {

/// 40,001 numbers of both signs over 6 decades with neighbours that are the same, infinities and NaN.
std::vector<double> mixed_numbers() {
  std::mt19937_64 bits(7);
  std::vector<double> numbers;
  while (numbers.size() < 40001) {
    const double x = std::pow(10, std::uniform_real_distribution<double>(-3, 3)(bits)) * (bits() % 2 == 0 ? 1 : -1);
    numbers.insert(numbers.end(), 1 + bits() % 3, x);
    if (bits() % 50 == 0) numbers.push_back(std::copysign(kInfinity, x));
    if (bits() % 50 == 0) numbers.push_back(kNaN);
  }
  return numbers;
}

/// The size of rank n / 2.
double upper_middle(std::vector<double> numbers) {
  std::erase_if(numbers, [](double x) { return !std::isfinite(x); });
  for (double& x : numbers) x = std::abs(x);
  std::sort(numbers.begin(), numbers.end());
  return numbers[numbers.size() / 2];
}

/// In pieces of 1000 that several counts take in turn.
SizeCounts counted(const std::vector<double>& numbers, const SizeCounts& empty, std::size_t takers) {
  std::vector<SizeCounts> counts(takers, empty);
  for (std::size_t at = 0; at < numbers.size(); at += 1000)
    counts[at / 1000 % takers].add(
        std::vector<double>(numbers.begin() + static_cast<std::ptrdiff_t>(at),
                            numbers.begin() + static_cast<std::ptrdiff_t>(std::min(at + 1000, numbers.size()))),
        at);
  for (std::size_t t = takers - 1; t > 0; --t) counts[t - 1].add(counts[t]);
  return counts[0];
}

/// By one pass or three.
double median_of(const std::vector<double>& numbers, double expected, std::size_t takers) {
  SizeCounts counts = counted(numbers, SizeCounts::near(expected), takers);
  if (!counts.has_median())
    counts = counted(numbers, SizeCounts::near(counted(numbers, SizeCounts::of_all(), takers).median()), takers);
  REQUIRE(counts.has_median());
  return counts.median();
}

}  // namespace

TEST_CASE("Counts of sizes add up to extremes, places and an exact median", "[stats]") {
  std::vector<double> numbers = mixed_numbers();
  numbers[12345] = -1e-9;
  numbers[23456] = 1e-9;
  numbers[34567] = 1e9;
  numbers[39999] = -1e9;
  std::vector<double> sizes;
  for (const double x : numbers)
    if (std::isfinite(x)) sizes.push_back(std::abs(x));
  for (const std::size_t takers : {1, 2, 7})
    for (const SizeCounts& empty : {SizeCounts(), SizeCounts::near(1.0), SizeCounts::of_all()}) {
      const SizeCounts counts = counted(numbers, empty, takers);
      CHECK(counts.smallest() == 1e-9);
      CHECK(counts.smallest_at() == 12345);
      CHECK(counts.largest() == 1e9);
      CHECK(counts.largest_at() == 34567);
      CHECK(counts.infinite() == static_cast<std::uint64_t>(std::count_if(numbers.begin(), numbers.end(),
                                                                          [](double x) { return std::isinf(x); })));
    }
  CHECK(counted(numbers, SizeCounts(), 3).median() == stats::median(sizes));
}

TEST_CASE("A counted median is within 1e-6, wherever it was expected", "[stats]") {
  const std::vector<double> numbers = mixed_numbers();
  const double middle = upper_middle(numbers);
  for (const double expected : {middle, middle * 1.001, middle * 1.04, 0.0, 1e-310, 1e300, kInfinity, kNaN}) {
    CAPTURE(expected);
    CHECK(std::abs(median_of(numbers, expected, 1) / middle - 1) < 1e-6);
    CHECK(median_of(numbers, expected, 4) == median_of(numbers, middle, 1));
  }
  CHECK(counted(numbers, SizeCounts::near(middle * 1.001), 1).has_median());
  CHECK_FALSE(counted(numbers, SizeCounts::near(middle * 1.1), 1).has_median());
  CHECK_FALSE(counted(numbers, SizeCounts::near(middle / 1.1), 1).has_median());
  CHECK(std::abs(counted(numbers, SizeCounts::of_all(), 2).median() / middle - 1) < 1. / 16);
}

TEST_CASE("Counts of sizes: zeros, ties and nothing", "[stats]") {
  // Three of five are zero, so that the median lies in the lowest bin of all, below which there is none.
  const std::vector<double> zeros = {0, -0.0, 5, 0, 1e308};
  CHECK(median_of(zeros, 0, 1) < 1e-300);
  CHECK(median_of(zeros, 5, 1) < 1e-300);
  // The fine bins begin at the lowest of all, and what is far above them is not below.
  CHECK(std::abs(median_of({0, 0, 1e-311, 7}, 0, 1) / 1e-311 - 1) < 0.01);  // few digits are left of such numbers
  CHECK(std::abs(median_of({3, 3, 3, 3}, 2.9, 2) / 3 - 1) < 1e-6);
  const SizeCounts empty = counted({kNaN, -kInfinity, kInfinity}, SizeCounts::near(1.0), 1);
  CHECK(empty.infinite() == 2);
  CHECK(std::isnan(empty.median()));
  CHECK(std::isnan(empty.smallest()));
  CHECK(std::isnan(empty.largest()));
  CHECK(std::isnan(SizeCounts().median()));
  CHECK(counted({1, -1, 1}, SizeCounts(), 1).largest_at() == 0);
}
