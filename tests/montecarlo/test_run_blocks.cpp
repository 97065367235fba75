#include "montecarlo/run_blocks.h"

#include <algorithm>
#include <atomic>
#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "normal_draws.h"

using namespace surveymc;
using namespace surveymc::montecarlo;

namespace {
stats::Tally kernel(TrialBlock block) {
  stats::Tally t{.trials = static_cast<std::uint64_t>(block.count),
                 .moments = stats::Moments::of(test::normal_draws(random::Stream(7, 0), block.first, block.count, 2)),
                 .samples = {static_cast<double>(block.first)}};
  for (std::uint64_t trial = block.first; trial < block.first + t.trials; ++trial)
    if (trial % 1000 == 3) t.failed_trials.push_back(trial);
  t.failed = t.failed_trials.size();
  return t;
}
bool same_bits(const stats::Tally& a, const stats::Tally& b) {
  return a.trials == b.trials && a.moments.count == b.moments.count && a.moments.mean == b.moments.mean &&
         a.moments.squares == b.moments.squares && a.moments.cubes == b.moments.cubes &&
         a.moments.fourths == b.moments.fourths && a.failed_trials == b.failed_trials && a.samples == b.samples;
}
}  // namespace

TEST_CASE("The tally has the same bits for 1, 2, 3, 7 threads and any number of blocks") {
  for (const std::uint64_t trials : {1u, 511u, 512u, 513u, 10001u}) {
    const stats::Tally one = run_blocks(trials, kernel, {1});
    CHECK(one.trials == trials);
    for (const int threads : {2, 3, 7}) CHECK(same_bits(one, run_blocks(trials, kernel, {threads})));
  }
}

TEST_CASE("Merging follows a fixed tree, in whatever order blocks arrive, and samples stay in order") {
  std::vector<std::uint64_t> order(37);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto merged = [&] {
    OrderedMerge m;
    for (const std::uint64_t b : order) m.add(b, kernel({b * kBlockTrials, kBlockTrials}));
    return m.whole();
  };
  const stats::Tally in_order = merged();
  CHECK(std::is_sorted(in_order.samples.begin(), in_order.samples.end()));
  CHECK(in_order.samples.size() == 37);
  std::mt19937 g(1);
  for (int rep = 0; rep < 10; ++rep) {
    std::shuffle(order.begin(), order.end(), g);
    CHECK(same_bits(in_order, merged()));
  }
}

TEST_CASE("A kernel's exception reaches the caller") {
  const auto throws = [](TrialBlock b) -> stats::Tally {
    if (b.first >= 2048) throw InputError("bad trial");
    return kernel(b);
  };
  CHECK_THROWS_AS(run_blocks(10000, throws, {2}), InputError);
}

TEST_CASE("A stop request ends the run with Interrupted") {
  std::atomic<bool> stop = false;
  const RunOptions options{
      .threads = 2, .progress = [&](std::uint64_t done, std::uint64_t) { stop = done > 2000; }, .stop = &stop};
  CHECK_THROWS_AS(run_blocks(100000000, kernel, options), Interrupted);
}

TEST_CASE("Progress counts every trial once") {
  std::uint64_t last = 0;
  RunOptions options{3};
  options.progress = [&](std::uint64_t done, std::uint64_t expected) {
    CHECK(done > last);
    CHECK(expected == 5000);
    last = done;
  };
  run_blocks(5000, kernel, options);
  CHECK(last == 5000);
}

TEST_CASE(
    "A stopping rule ends the run at a look, the same for any threads, with the bits of a run of as many trials") {
  const StoppingRule rule{{1024, 2048, 4096, 10000},
                          [](const stats::Tally& t) { return t.trials < 2000 ? 1700u : 2048u; }};
  const stats::Tally fixed = run_blocks(2048, kernel, {1});
  for (const int threads : {1, 2, 3, 7}) {
    const stats::Tally stopped = run_blocks(10000, kernel, {threads}, rule);
    CHECK(stopped.trials == 2048);
    CHECK(same_bits(fixed, stopped));
  }
  const StoppingRule never{{1024, 10000}, [](const stats::Tally&) { return std::uint64_t{1} << 60; }};
  CHECK(same_bits(run_blocks(10000, kernel, {2}, never), run_blocks(10000, kernel, {1})));
}

TEST_CASE("The expected number of trials follows the rule") {
  std::vector<std::uint64_t> expected;
  RunOptions options{1};
  options.progress = [&](std::uint64_t, std::uint64_t of) { expected.push_back(of); };
  run_blocks(10000, kernel, options,
             {{1024, 4096}, [](const stats::Tally& t) { return t.trials == 1024 ? 3500u : 4000u; }});
  CHECK(expected.front() == 10000);
  CHECK(expected.back() == 3500);
  CHECK(expected.size() == 8);  // blocks of 512 up to the second look
}
