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
  CHECK(std::abs(i.lo - (0.2 - half)) < 1e-6);
  CHECK(std::abs(i.hi - (0.2 + half)) < 1e-6);
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
