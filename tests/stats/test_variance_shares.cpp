/// Shares of a variance by groups: Ishigami's function, whose shares are known.
#include <array>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "base/units.h"
#include "random/design_points.h"
#include "stats/variance_shares.h"

using namespace surveymc;
using namespace surveymc::stats;

namespace {

constexpr std::uint32_t kGroups = 10;

/// sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, x uniform in [-pi, pi] (Saltelli et al. 2008): variance a^2 / 8 + b pi^4 / 5
/// + b^2 pi^8 / 18 + 1/2.
double ishigami(const std::array<double, 3>& x) {
  return std::sin(x[0]) + 7 * std::pow(std::sin(x[1]), 2) + 0.1 * std::pow(x[2], 4) * std::sin(x[0]);
}

double variance() { return 49.0 / 8 + 0.1 * std::pow(kPi, 4) / 5 + 0.01 * std::pow(kPi, 8) / 18 + 0.5; }

/// Share of the means of kGroups equal intervals of a function of one input with mean 0, over the whole variance.
template <class Effect>
double grouped_share(const Effect& effect) {
  double sum = 0;
  constexpr int kSteps = 1000;
  for (std::uint32_t g = 0; g < kGroups; ++g) {
    double mean = 0;
    for (int i = 0; i < kSteps; ++i) mean += effect(2 * kPi * ((g + (i + 0.5) / kSteps) / kGroups - 0.5)) / kSteps;
    sum += mean * mean / kGroups;
  }
  return sum / variance();
}

}  // namespace

TEST_CASE("Shares of Ishigami's function: without bias, and standard errors that cover") {
  constexpr std::uint64_t kPoints = 1000, kDesigns = 200;
  const std::array<double, 3> truth{
      grouped_share([](double x) { return (1 + 0.1 * std::pow(kPi, 4) / 5) * std::sin(x); }),
      grouped_share([](double x) { return 7 * (std::pow(std::sin(x), 2) - 0.5); }), 0};
  CHECK(truth[0] < 0.3139);  // what varies within a group is not explained
  CHECK(truth[0] > 0.3139 * 0.96);
  CHECK(truth[1] < 0.4424);
  std::array<double, 3> sum{}, squares{};
  int covered = 0;
  for (std::uint64_t design = 0; design < kDesigns; ++design) {
    std::array<std::vector<std::uint32_t>, 3> group;
    std::vector<double> y;
    for (std::uint64_t i = 0; i < kPoints; ++i) {
      std::array<double, 3> x{};
      for (unsigned axis = 0; axis < 3; ++axis) {
        const double u = random::latin_hypercube(i, kPoints, axis, design);
        x[axis] = kPi * (2 * u - 1);
        group[axis].push_back(static_cast<std::uint32_t>(u * kGroups));
      }
      y.push_back(ishigami(x));
    }
    for (unsigned axis = 0; axis < 3; ++axis) {
      const ExplainedShare s = explained_share(y, group[axis], kGroups);
      sum[axis] += s.share;
      squares[axis] += s.share * s.share;
      covered += std::abs(s.share - truth[axis]) <= 1.96 * standard_error_of(s.influence);
    }
  }
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double mean = sum[axis] / kDesigns, sd = std::sqrt(squares[axis] / kDesigns - mean * mean);
    CHECK(std::abs(mean - truth[axis]) < 4 * sd / std::sqrt(1.0 * kDesigns));
  }
  // The hypercube only makes shares more certain than the standard errors, which take the points as independent.
  CHECK(covered >= 3 * kDesigns * 0.95 - 3 * std::sqrt(3 * kDesigns * 0.95 * 0.05));
}

TEST_CASE("What groups explain: all, nothing, and groups of one") {
  const std::vector<double> y{1, 1, 5, 5, 9, 9};
  CHECK(explained_share(y, {0, 0, 1, 1, 2, 2}, 3).share == 1);
  CHECK(std::isnan(explained_share(y, {0, 1, 2, 3, 4, 5}, 6).share));
  CHECK(std::isnan(explained_share({2, 2, 2}, {0, 0, 1}, 2).share));
  // y has variance 64 / 5; within {1, 5} and {9, 9} it is 8 and 0, and 1, 5 stand alone
  CHECK_THAT(explained_share(y, {0, 1, 0, 2, 3, 3}, 4).share, Catch::WithinRel(1 - 4 / (64.0 / 5), 1e-14));
}

TEST_CASE("What groups explain of values that are all that there is") {
  // y = 4 a + b + a b, a in {0, 1}, b in {0, 1, 2}
  const std::vector<double> y{0, 1, 2, 4, 6, 8};
  // mean 3.5, squares 47.5; means of a 1 and 6: 3 (2.5^2 + 2.5^2); of b 2, 3.5, 5: 2 (1.5^2 + 1.5^2)
  CHECK_THAT(share_of_groups(y, {0, 0, 0, 1, 1, 1}, 2), Catch::WithinRel(37.5 / 47.5, 1e-14));
  CHECK_THAT(share_of_groups(y, {0, 1, 2, 0, 1, 2}, 3), Catch::WithinRel(9 / 47.5, 1e-14));
  CHECK(share_of_groups(y, {0, 1, 2, 3, 4, 5}, 6) == 1);
  CHECK(std::isnan(share_of_groups({2, 2, 2}, {0, 0, 1}, 2)));
}

TEST_CASE("Chance gives a share of nothing the standard error of a beta distribution") {
  constexpr std::uint32_t kFew = 3;
  constexpr std::size_t kValues = 24;
  constexpr int kTimes = 4000;
  std::vector<std::uint32_t> group;
  for (std::uint32_t i = 0; i < kValues; ++i) group.push_back(i % kFew);
  std::mt19937_64 source(5);
  double squares = 0;
  for (int t = 0; t < kTimes; ++t) {
    std::vector<double> y(kValues);
    for (double& v : y) v = std::normal_distribution<double>()(source);
    squares += std::pow(explained_share(y, group, kFew).share, 2) / kTimes;
  }
  // The square of a share is its variance, as its mean is 0; with heavy tails the mean of 4000 is known to 5 %.
  CHECK_THAT(std::sqrt(squares), Catch::WithinRel(chance_of_share(kFew - 1, kValues), 0.08));
}

TEST_CASE("Correlation of ranks") {
  CHECK(rank_correlation({1, 2, 3, 4}, {10, 100, 1000, 1e9}) == 1);
  CHECK(rank_correlation({1, 2, 3, 4}, {4, 3, 2, 1}) == -1);
  CHECK_THAT(rank_correlation({1, 1, 2, 3}, {1, 2, 3, 4}), Catch::WithinRel(4.5 / std::sqrt(4.5 * 5), 1e-14));
  CHECK(std::isnan(rank_correlation({1, 1}, {1, 2})));
}
