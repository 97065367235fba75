#include "stats/weighted_hits.h"

#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "stats/intervals.h"
#include "stats/normal_tail.h"
#include "stats/tally.h"
#include "stats/tally_bytes.h"

using namespace surveymc;
using Catch::Matchers::WithinRel;
using stats::WeightedHits;

namespace {

WeightedHits hits_of(std::uint64_t count, double weight) {
  WeightedHits h;
  for (std::uint64_t i = 0; i < count; ++i) h.add(weight);
  return h;
}

}  // namespace

TEST_CASE("Few hits of equal weight have the exact interval of a Poisson count", "[weighted]") {
  // chi2(a; 2 k)/2 and chi2(1 - a; 2 k + 2)/2, over N; v = k - k^2/N leaves a part of k/N. Whatever the weight is.
  const std::uint64_t trials = 100'000'000;
  for (const double weight : {1.0, 3e-9, 1e-150})
    for (const std::uint64_t k : {1, 5, 40}) {
      CAPTURE(weight, k);
      const auto n = static_cast<double>(trials), degrees = 2 * static_cast<double>(k);
      const stats::Interval i = stats::weighted_interval(hits_of(k, weight), trials, 0.95, false);
      CHECK_THAT(i.lo, WithinRel(weight * stats::chi_squared_quantile(degrees, 0.025) / 2 / n, 1e-5));
      CHECK_THAT(i.hi, WithinRel(weight * stats::chi_squared_quantile(degrees + 2, 0.975) / 2 / n, 1e-5));
    }
}

TEST_CASE("Without hits a plain run has a bound, and weights have none", "[weighted]") {
  const stats::Interval plain = stats::weighted_interval({}, 1000, 0.95, true);
  CHECK(plain.lo == 0);
  CHECK_THAT(plain.hi, WithinRel(-std::log(0.025) / 1000, 1e-14));
  CHECK(std::isnan(stats::weighted_interval({}, 1000, 0.95, false).hi));
  CHECK_FALSE(stats::weighted_probability({}, {}, 1000, 0.95, false).trusted);
  const auto lost = stats::weighted_probability(hits_of(3, 0), {}, 1000, 0.95, false);  // weights that are no numbers
  CHECK(lost.value == 0);
  CHECK_FALSE(lost.trusted);
  // Every trial hits with one weight: nothing varies below.
  CHECK_THAT(stats::weighted_interval(hits_of(50, 0.5), 50, 0.95, false).lo, WithinRel(0.5, 1e-12));
  // All but one: the spread is the deficit d of one weight, and the sum all but normal. Boost's gamma functions fail
  // there.
  for (const double d : {1e-3, 1e-4, 1e-5}) {
    WeightedHits hits = hits_of(999, 0.5);
    hits.add(0.5 * (1 - d));
    const double lo = stats::weighted_interval(hits, 1000, 0.95, false).lo;
    // The variance, d^2 / 4, is a difference of two sums of 250; what is not normal is d / 1000 of the rest.
    const double tolerance = 2e-6 + 250 * std::numeric_limits<double>::epsilon() / (d * d / 4);
    CHECK_THAT(1000 * (1 - 2 * lo), WithinRel(d * (1 + 1.959964 * std::sqrt(0.999)), tolerance));
  }
}

TEST_CASE("Trust takes a hundred effective hits, none above a twentieth, and a result of nearly all trials",
          "[weighted]") {
  CHECK(stats::weighted_probability(hits_of(100, 1e-7), {}, 1000, 0.95, false).trusted);
  CHECK_FALSE(stats::weighted_probability(hits_of(99, 1e-7), {}, 1000, 0.95, false).trusted);
  WeightedHits one_large = hits_of(10'000, 1e-7);
  one_large.add(600e-7);  // 5.7 % of the sum, 780 effective hits
  CHECK_FALSE(stats::weighted_probability(one_large, {}, 20'000, 0.95, false).trusted);
  CHECK(stats::weighted_probability(hits_of(200, 1e-7), hits_of(2, 1e-7), 1000, 0.95, false).trusted);
  CHECK_FALSE(stats::weighted_probability(hits_of(200, 1e-7), hits_of(3, 1e-7), 1000, 0.95, false).trusted);
}

TEST_CASE("The smallest weights have squares, with the bits that others have", "[weighted]") {
  constexpr int kBelow = -570;  // 2^-570 = 2.6e-172: its square is no number
  WeightedHits usual, small, first, second;
  for (int i = 0; i < 2000; ++i) {
    const double weight = 1 + 0.3 * std::sin(i);
    usual.add(weight);
    small.add(std::ldexp(weight, kBelow));
    (i < 700 ? first : second).add(std::ldexp(weight, kBelow));
  }
  CHECK(small.effective_hits() == usual.effective_hits());
  CHECK(small.effective_hits() > 1900);
  const auto p = stats::weighted_probability(small, {}, 4000, 0.95, false),
             of_usual = stats::weighted_probability(usual, {}, 4000, 0.95, false);
  CHECK(p.trusted);
  CHECK(p.note.empty());
  CHECK(p.interval.lo == std::ldexp(of_usual.interval.lo, kBelow));
  CHECK(std::isfinite(p.relative_efficiency));
  first.merge(second);
  CHECK(first.effective_hits() == Approx(small.effective_hits()).epsilon(1e-12));
  // Weights of very different size: the small ones are nothing beside the large one, from either side.
  WeightedHits large = hits_of(1, 3), other = small;
  large.merge(small);
  other.merge(hits_of(1, 3));
  CHECK(large.squares == 2.25);
  CHECK(other.squares == 2.25);
  CHECK(other.effective_hits() == 1);
}

TEST_CASE("95 % gamma intervals hold the probability at 6, 28 and 150 effective hits", "[weighted]") {
  // A half space at beta = 4.2649 (1e-5), drawn from a normal shifted by beta: weights exp(beta^2/2 - beta y).
  // Expected coverage 0.970, 0.968 and 0.94 to 0.96 (2000 runs each: one standard error is 0.005 or less); five of
  // these.
  const double beta = 4.264890793922825, p = stats::normal_upper_tail(beta);
  struct Case {
    int trials;
    double lo, hi;
  };
  for (const Case c : {Case{40, 0.945, 0.995}, Case{190, 0.943, 0.990}, Case{1000, 0.928, 0.975}}) {
    std::mt19937_64 generator(22);
    std::normal_distribution<double> normal(beta, 1);
    int held = 0;
    for (int run = 0; run < 2000; ++run) {
      WeightedHits h;
      for (int i = 0; i < c.trials; ++i)
        if (const double y = normal(generator); y >= beta) h.add(std::exp(beta * (beta / 2 - y)));
      const stats::Interval i = stats::weighted_interval(h, static_cast<std::uint64_t>(c.trials), 0.95, false);
      held += i.lo <= p && p <= i.hi;
    }
    CAPTURE(c.trials);
    CHECK(held > 2000 * c.lo);
    CHECK(held < 2000 * c.hi);
  }
}

TEST_CASE("Weighted hits merge and keep their bits; those of two proposals do not go together", "[weighted]") {
  stats::Tally a, b;
  a.trials = b.trials = 3;
  a.weighted = {hits_of(3, 0.25), {}};
  b.weighted = {hits_of(2, 1.5), hits_of(1, 7)};
  a.proposal = b.proposal = 77;
  REQUIRE(stats::can_merge(a, b));
  a.merge(b);
  CHECK(a.weighted[0].count == 5);
  CHECK(a.weighted[0].sum == 3.75);
  CHECK(a.weighted[0].squares == 4.6875);
  CHECK(a.weighted[0].largest == 1.5);
  CHECK(a.weighted[1].sum == 7);
  const stats::Tally read = stats::tally_from_bytes(stats::tally_to_bytes(a));
  CHECK(read.proposal == 77);
  REQUIRE(read.weighted.size() == 2);
  CHECK(read.weighted[0].squares == a.weighted[0].squares);
  CHECK(read.weighted[1].largest == 7);
  b.proposal = 78;
  CHECK_FALSE(stats::can_merge(a, b));
}
