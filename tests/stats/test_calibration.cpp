#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "stats/calibration.h"
#include "stats/confidence_sequence.h"
#include "stats/normal_tail.h"
#include "stats/simultaneous_band.h"

using namespace surveymc;
using namespace surveymc::stats;

namespace {

/// Counts of one quantity from errors.
std::vector<std::uint64_t> slots_of(const PitCells& cells, const std::vector<double>& errors) {
  std::vector<std::uint64_t> slots(kPitSlots, 0);
  for (const double x : errors) ++slots[cells.of(x)];
  return slots;
}

std::vector<double> normal_errors(std::size_t n, double mean, double sd, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> draw(mean, sd);
  std::vector<double> x(n);
  for (double& v : x) v = draw(engine);
  return x;
}

CalibrationResult judged(const std::vector<double>& errors, double margin, ClaimedLaw law = {}) {
  const PitCells cells = law.degrees > 0 ? PitCells::chi_squared(law.degrees) : PitCells::normal();
  return judge_calibration(pit_counts(slots_of(cells, errors)), errors.size(), law, margin, 0.95);
}

}  // namespace

TEST_CASE("The level of the simultaneous band is that of its table") {
  // Exact recursion; gamma as it is printed, to its last digit.
  CHECK(band_level(100, 100, 0.95) == Approx(0.00411).epsilon(0.005));
  CHECK(band_level(1000, 100, 0.95) == Approx(0.00267).epsilon(0.005));
  CHECK(band_level(4096, 100, 0.95) == Approx(0.00243).epsilon(0.005));
  CHECK(band_quantile(100, 20, 0.95) == Approx(2.63).epsilon(0.003));
  CHECK(band_quantile(1000, 20, 0.95) == Approx(2.77).epsilon(0.003));
  CHECK(band_quantile(100'000'000'000, 100, 0.95) == Approx(3.07).epsilon(0.003));
  CHECK(band_quantile(100'000'000'000, 100, 0.99) == Approx(3.58).epsilon(0.003));
  // Where the recursion ends and the bridge begins, the two agree to what the bridge claims.
  CHECK(band_quantile(kMostExact, 100, 0.95) == Approx(band_quantile(kMostExact + 1, 100, 0.95)).epsilon(0.01));
}

TEST_CASE("The p-value of a band is the chance of a smallest pointwise p") {
  for (const std::uint64_t n : {1000, 30'000}) {
    const double gamma = band_level(n, 100, 0.95);
    // The probability of the counts has steps: a band that holds 95 % or a little more.
    CHECK(band_p_value(n, 100, gamma) == Approx(0.05).epsilon(0.05));
    CHECK(band_p_value(n, 100, gamma / 10) < 0.01);
  }
  CHECK(band_p_value(1000, 100, 1) == 1);
  CHECK(band_p_value(1000, 100, 1e-300) == Approx(99e-300).epsilon(1e-9));
  CHECK(pointwise_p(0, 10, 0.5) == Approx(2.0 / 1024).epsilon(1e-12));
}

TEST_CASE("An error falls into the slot of its u, at the edges too") {
  const PitCells cells = PitCells::normal(2);
  const std::vector<double> edges{0.01, 0.02, 0.025, 0.03, 0.5, 0.97, 0.975, 0.98, 0.99};
  const std::vector<std::size_t> slot{1, 2, 3, 4, 51, 98, 99, 100, 101};
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const double x = 2 * normal_quantile(edges[i]);
    CHECK(cells.of(x) == slot[i]);
    CHECK(cells.of(std::nextafter(x, -10.0)) == slot[i] - 1);
  }
  CHECK(cells.of(-1e300) == 0);
  CHECK(cells.of(1e300) == kPitBins + 1);
  CHECK(cells.of(std::nan("")) == kPitUnjudged);
  CHECK(PitCells::normal(0).of(1) == kPitUnjudged);
  // Every slot of a fine grid is the one that its u says.
  const PitCells one = PitCells::normal();
  for (double x = -4; x < 4; x += 0.00137) {
    const double u = 1 - normal_upper_tail(x);
    const std::size_t expected = static_cast<std::size_t>(u * 100) + (u >= 0.025) + (u >= 0.975);
    CHECK(one.of(x) == expected);
  }
}

TEST_CASE("Errors counted together fall into the slots of each alone") {
  std::vector<double> x{kNaN, kInfinity, -kInfinity, 1e300, -1e300, 0};
  for (double v = -9; v < 40; v += 0.00193) x.push_back(v);
  for (const double u : {0.01, 0.025, 0.5, 0.975, 0.99})
    for (const double edge : {normal_quantile(u), chi_squared_quantile(6, u)})
      for (const double v : {edge, std::nextafter(edge, -10.0), std::nextafter(edge, 1e3)}) x.push_back(v);
  // The last has more than one edge in a part of its way; the one before judges nothing.
  for (const PitCells& cells : {PitCells::normal(), PitCells::normal(0.3), PitCells::chi_squared(6),
                                PitCells::normal_angle(0.1), PitCells::normal(0), PitCells::chi_squared(1)})
    for (const double offset : {0.0, 0.25}) {
      std::vector<std::uint64_t> together(kPitSlots, 3), alone(kPitSlots, 3);
      for (const double v : x) ++alone[cells.of(v + offset)];
      cells.count(x.data(), x.size(), offset, together.data());
      CHECK(together == alone);
    }
}

TEST_CASE("An angle is judged by its tangent") {
  const double sd = 0.2;
  const PitCells angles = PitCells::normal_angle(sd), numbers = PitCells::normal(sd);
  for (double a = -1.5; a < 1.5; a += 0.0011) CHECK(angles.of(std::tan(a)) == numbers.of(a));
  CHECK(angles.of(kInfinity) == numbers.of(2.0));            // beyond a right angle
  CHECK(PitCells::normal_angle(0.7).of(0) == kPitUnjudged);  // 2 sd are a right angle
}

TEST_CASE("Counts of a tally give bins, the central 95 % and what was not judged") {
  std::vector<std::uint64_t> slots(kPitSlots, 1);
  slots[kPitUnjudged] = 7;
  const PitCounts c = pit_counts(slots);
  CHECK(c.total == kPitBins + 2);
  CHECK(c.bins[2] == 2);
  CHECK(c.bins[97] == 2);
  CHECK(c.bins[50] == 1);
  CHECK(c.central95 == kPitBins + 2 - 6);
  CHECK(c.unjudged == 7);
}

TEST_CASE("What would decide a calibration is a number of trials, also where pairs are counted") {
  // Both trials of a pair in the same slot: all that the counts say is what half as many say of single trials.
  std::vector<std::uint64_t> once = slots_of(PitCells::normal(), normal_errors(2000, 0, 1, 3)), twice = once;
  for (std::uint64_t& count : twice) count *= 2;
  const CalibrationResult single = judge_calibration(pit_counts(once), 2000, {}, 0.02, 0.95),
                          paired = judge_calibration(pit_counts(twice), 2000, {}, 0.02, 0.95);
  REQUIRE(single.verdict == "undecided");
  CHECK(paired.verdict == "undecided");
  CHECK(static_cast<double>(paired.trials_to_decide) ==
        Approx(2 * static_cast<double>(single.trials_to_decide)).margin(1));
  CHECK(paired.p_agrees == single.p_agrees);
}

TEST_CASE("A deviation is named by its shape and its size") {
  constexpr std::size_t kTrials = 200'000;  // standard errors of D at most 0.0011
  const CalibrationResult sd = judged(normal_errors(kTrials, 0, 1.05, 1), 0.01);
  CHECK(sd.shape == "sd");
  CHECK(sd.size == Approx(0.05).margin(4 / std::sqrt(2.0 * kTrials)).epsilon(0.05));
  CHECK(std::abs(sd.largest) == Approx(0.24 * 0.05).margin(4 * 0.0011).epsilon(1e-9));
  const CalibrationResult shift = judged(normal_errors(kTrials, 0.2, 1, 2), 0.01);
  CHECK(shift.shape == "shift");
  CHECK(shift.size == Approx(0.2).margin(4 / std::sqrt(double(kTrials))).epsilon(0.02));
  CHECK(shift.verdict == "differs");
  CHECK(shift.largest < 0);  // errors are too large: too few below
  CHECK(judged(normal_errors(kTrials, 0, 1, 3), 0.01).verdict == "agrees");
  CHECK(judged(normal_errors(2000, 0, 1, 3), 0.01).verdict == "undecided");
  // A sum of squares of six errors, all of them 3 % too large.
  std::vector<double> squares(kTrials, 0);
  for (unsigned i = 0; i < 6; ++i) {
    const std::vector<double> x = normal_errors(kTrials, 0, 1.03, 10 + i);
    for (std::size_t t = 0; t < kTrials; ++t) squares[t] += x[t] * x[t];
  }
  const CalibrationResult nees = judged(squares, 0.01, {6});
  CHECK(nees.shape == "sd");
  CHECK(nees.size == Approx(0.03).epsilon(0.1));
  CHECK(nees.verdict == "differs");
}

TEST_CASE("The band finds an error of 5 % of an sd in nine of ten runs of 6000 trials, and none where there is none",
          "[long]") {
  int found = 0, cried = 0;
  constexpr int kRuns = 200;
  for (unsigned run = 0; run < kRuns; ++run) {
    found += judged(normal_errors(6000, 0, 1.05, 100 + run), 0).verdict == "differs";
    cried += judged(normal_errors(6000, 0, 1, 1000 + run), 0).verdict == "differs";
    CHECK(std::isnan(judged(normal_errors(6000, 0, 1, 1000 + run), 0).p_agrees));
  }
  CHECK(found >= 0.9 * kRuns - 3 * std::sqrt(0.9 * 0.1 * kRuns));
  CHECK(cried <= 0.05 * kRuns + 3 * std::sqrt(0.05 * 0.95 * kRuns));
}

TEST_CASE("Pairs count as one: a band of n pairs is that of n trials") {
  std::vector<std::uint64_t> slots = slots_of(PitCells::normal(), normal_errors(4000, 0.1, 1, 5)), twice = slots;
  for (std::uint64_t& n : twice) n *= 2;
  const CalibrationResult one = judge_calibration(pit_counts(slots), 4000, {}, 0.01, 0.95),
                          two = judge_calibration(pit_counts(twice), 4000, {}, 0.01, 0.95);
  CHECK(one.p_band == two.p_band);
  CHECK(one.interval.lo == two.interval.lo);
  CHECK(one.p_chi_squared == Approx(two.p_chi_squared).epsilon(1e-9));
}

TEST_CASE("Confidence sequences have the published constants") {
  // normal_mixture_bound(n, 0.05, 40960, 0.05, two-sided) / sqrt n of confseq, to the digits printed.
  const std::vector<std::pair<std::uint64_t, double>> constants{{4096, 3.855},    {8192, 3.364},    {40'960, 3.035},
                                                                {100'000, 3.077}, {409'600, 3.242}, {1'000'000, 3.365}};
  for (const auto& [n, c] : constants) CHECK(sequence_quantile(n, 0.95) == Approx(c).margin(0.0005).epsilon(1e-9));
  const Interval a = rate_sequence(40, 4096, 0.95), b = rate_sequence(400, 40'960, 0.95),
                 none = rate_sequence(0, 4096, 0.95);
  CHECK(a.lo == Approx(0.0050962).epsilon(1e-4));
  CHECK(a.hi == Approx(0.0172213).epsilon(1e-5));
  CHECK(b.lo == Approx(0.0083558).epsilon(1e-5));
  CHECK(b.hi == Approx(0.0113067).epsilon(1e-5));
  CHECK(none.lo == 0);
  CHECK(none.hi == Approx(0.0027659).epsilon(1e-4));
  // The p-value is 5 % at the bounds of the 95 % sequence.
  for (const double bound : {a.lo, a.hi}) CHECK(rate_sequence_p(40, 4096, bound) == Approx(0.05).epsilon(1e-6));
  CHECK(rate_sequence_p(0, 4096, none.hi) == Approx(0.05).epsilon(1e-6));
  CHECK(rate_sequence_p(40, 4096, 40.0 / 4096) == 1);
  CHECK(rate_sequence_p(1, 10, 0) == 0);
  CHECK(rate_sequence_p(0, 10, 0) == 1);
  CHECK(rate_sequence_p(9, 10, 1) == 0);
  CHECK(rate_sequence_p(10, 10, 1) == 1);
  const Interval all = rate_sequence(4096, 4096, 0.95);
  CHECK(all.lo == Approx(1 - none.hi).epsilon(1e-9));
  CHECK(all.hi == 1);
  // Of a normal sample: as wide as the sequence's quantile says.
  const Interval sd = sd_sequence({40'960, 0, 4, 4, 3, 0, 3}, 0.95);
  CHECK(std::log(sd.hi / 2) == Approx(3.035 * std::sqrt(1 / (2 * 40'960.0))).epsilon(2e-4));
  CHECK(sequence_confidence(40'960, 0.95) ==
        Approx(1 - 2 * normal_upper_tail(sequence_quantile(40'960, 0.95))).epsilon(1e-12));
}
