#include "base/units.h"
#include "stats/histogram.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace surveymc;
using namespace surveymc::stats;

TEST_CASE("Quantiles of a histogram are those of the values, to a bin") {
  const HistogramBins bins{1000, 0.005};
  std::vector<std::uint64_t> counts(bins.bins, 0);
  constexpr int kValues = 100000;
  for (int i = 0; i < kValues; ++i)  // Rayleigh's own quantiles
    ++counts[bins.bin(std::sqrt(-std::log1p(-(i + 0.5) / kValues)))];
  for (const double p : {0.05, 0.25, 0.5, 0.75, 0.95})
    CHECK(std::abs(histogram_quantile(bins, counts.data(), p) - std::sqrt(-std::log1p(-p))) < bins.width);
  CHECK(histogram_quantile(bins, counts.data(), 0) >= 0);
  CHECK(histogram_quantile(bins, counts.data(), 1) <= 5);
}

TEST_CASE("The interval of a quantile is as wide as order statistics make it") {
  // Uniform on (0, 1): the sd of a quantile is sqrt(p (1 - p) / n).
  const HistogramBins bins{1000, 0.001};
  const std::vector<std::uint64_t> counts(bins.bins, 40);  // n = 40,000
  const Interval i = histogram_quantile_interval(bins, counts.data(), 0.2, 0.95);
  const double half = 1.959964 * std::sqrt(0.2 * 0.8 / 40000);
  // Ranks are whole numbers, and the normal approximation of a rank is off by less than one.
  CHECK(std::abs(i.lo - (0.2 - half)) < 2.0 / 40000);
  CHECK(std::abs(i.hi - (0.2 + half)) < 2.0 / 40000);
}

TEST_CASE("The interval of a quantile is exact for few values, and open where no order statistic will do") {
  const auto of = [](std::size_t n, double probability) {  // the k-th value is k
    return histogram_quantile_interval({n, 1}, std::vector<std::uint64_t>(n, 1).data(), probability, 0.95);
  };
  // Of 20 values the 6th and the 15th hold the median: P(B < 6) = 0.0207, P(B < 7) = 0.0577 for B binomial(20, 1/2).
  CHECK(of(20, 0.5).lo == 6);
  CHECK(of(20, 0.5).hi == 15);
  // 1 - 0.95^n >= 0.975 from n = 72 on.
  CHECK(of(71, 0.95).hi == kInfinity);
  CHECK(of(72, 0.95).hi == 72);
  CHECK(of(71, 0.05).lo == 0);
  CHECK(of(72, 0.05).lo == 1);
  const std::vector<std::uint64_t> none(4, 0), huge(1000, 1'000'000'000);
  CHECK(std::isnan(histogram_quantile_interval({4, 1}, none.data(), 0.5, 0.95).lo));
  const Interval narrow = histogram_quantile_interval({1000, 0.001}, huge.data(), 0.95, 0.95);
  CHECK((narrow.hi - narrow.lo) == Approx(2 * 1.959964 * std::sqrt(0.95 * 0.05 / 1e12)).epsilon(1e-4));
}

TEST_CASE("Values up to one are counted by the line that quantiles lie on") {
  const HistogramBins bins{4, 0.5};
  const std::vector<std::uint64_t> counts{4, 0, 10, 1};
  CHECK(histogram_total(bins, counts.data()) == 15);
  for (const auto& [value, count] :
       {std::pair(-1.0, 0), {0.0, 0}, {0.25, 2}, {0.75, 4}, {1.25, 9}, {1.99, 14}, {2.0, 15}, {9.0, 15}})
    CHECK(histogram_count(bins, counts.data(), value) == static_cast<std::uint64_t>(count));
}

TEST_CASE("Values beyond the bins count in the nearest one, and no counts have no quantile") {
  const HistogramBins bins{4, 1};
  CHECK(bins.bin(-3) == 0);
  CHECK(bins.bin(kNaN) == 0);
  CHECK(bins.bin(0.999) == 0);
  CHECK(bins.bin(1) == 1);
  CHECK(bins.bin(1e300) == 3);
  const std::vector<std::uint64_t> none(4, 0), gap{2, 0, 0, 2};
  CHECK(std::isnan(histogram_quantile(bins, none.data(), 0.5)));
  CHECK(histogram_quantile(bins, gap.data(), 0.5) == 1);
  CHECK(histogram_quantile(bins, gap.data(), 0.75) == 3.5);
}
