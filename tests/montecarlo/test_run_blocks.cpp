#include "montecarlo/run_blocks.h"

#include <algorithm>
#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "random/stream.h"

using namespace surveymc;

namespace {
Tally kernel(TrialBlock block) {
  const Stream stream(7, 0);
  Eigen::MatrixXd x(2, block.count);
  Tally t;
  for (int i = 0; i < block.count; ++i) {
    const std::uint64_t trial = block.first + static_cast<std::uint64_t>(i);
    for (std::uint32_t j = 0; j < 2; ++j) x(j, i) = stream.normal(trial, Channel::magnetometer_noise, j);
    if (trial % 1000 == 3) t.failed_trials.push_back(trial);
  }
  t.trials = static_cast<std::uint64_t>(block.count);
  t.failed = t.failed_trials.size();
  t.moments = Moments::of(x);
  t.samples = {static_cast<double>(block.first)};
  return t;
}
bool same_bits(const Tally& a, const Tally& b) {
  return a.trials == b.trials && a.moments.count == b.moments.count && a.moments.mean == b.moments.mean &&
         a.moments.squares == b.moments.squares && a.moments.cubes == b.moments.cubes &&
         a.moments.fourths == b.moments.fourths && a.failed_trials == b.failed_trials && a.samples == b.samples;
}
}  // namespace

TEST_CASE("The tally has the same bits for 1, 2, 3, 7 threads and any number of blocks") {
  for (const std::uint64_t trials : {1u, 511u, 512u, 513u, 10001u}) {
    const Tally one = run_blocks(trials, kernel, {1});
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
    return m.finish();
  };
  const Tally in_order = merged();
  CHECK(std::is_sorted(in_order.samples.begin(), in_order.samples.end()));
  CHECK(in_order.samples.size() == 37);
  std::mt19937 g(1);
  for (int rep = 0; rep < 10; ++rep) {
    std::shuffle(order.begin(), order.end(), g);
    CHECK(same_bits(in_order, merged()));
  }
}

TEST_CASE("A kernel's exception reaches the caller") {
  const auto throws = [](TrialBlock b) -> Tally {
    if (b.first >= 2048) throw InputError("bad trial");
    return kernel(b);
  };
  CHECK_THROWS_AS(run_blocks(10000, throws, {2}), InputError);
}

TEST_CASE("A stop request ends the run with Interrupted") {
  std::atomic<bool> stop = false;
  RunOptions options{2};
  options.stop = &stop;
  options.progress = [&](std::uint64_t done) { stop = done > 2000; };
  CHECK_THROWS_AS(run_blocks(100000000, kernel, options), Interrupted);
}

TEST_CASE("Progress counts every trial once") {
  std::uint64_t last = 0;
  RunOptions options{3};
  options.progress = [&](std::uint64_t done) {
    CHECK(done > last);
    last = done;
  };
  run_blocks(5000, kernel, options);
  CHECK(last == 5000);
}
