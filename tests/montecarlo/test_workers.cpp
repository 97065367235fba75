#include "montecarlo/workers.h"

#include <chrono>
#include <cstdio>
#include <deque>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "base/error.h"
#include "montecarlo/block_queue.h"
#include "normal_draws.h"
#include "stats/tally_bytes.h"

using namespace surveymc;
using namespace surveymc::montecarlo;

namespace {

/// Ranks that are threads of this process.
class Mailboxes {
 public:
  explicit Mailboxes(int ranks) : boxes_(static_cast<std::size_t>(ranks)) {}
  void send(int from, int to, const std::string& bytes) {
    const std::scoped_lock lock(mutex_);
    boxes_[static_cast<std::size_t>(to)].push_back({from, bytes});
  }
  std::optional<Message> take(int rank) {
    const std::scoped_lock lock(mutex_);
    auto& box = boxes_[static_cast<std::size_t>(rank)];
    if (box.empty()) return std::nullopt;
    Message m = std::move(box.front());
    box.pop_front();
    return m;
  }
  int ranks() const { return static_cast<int>(boxes_.size()); }

 private:
  std::mutex mutex_;
  std::vector<std::deque<Message>> boxes_;
};

class ThreadMessages : public Messages {
 public:
  ThreadMessages(Mailboxes& boxes, int rank) : boxes_(boxes), rank_(rank) {}
  int rank() const override { return rank_; }
  int count() const override { return boxes_.ranks(); }
  int threads() const override { return 1; }
  void send(int to, const std::string& bytes) override { boxes_.send(rank_, to, bytes); }
  [[noreturn]] void abort(int) override { std::terminate(); }
  std::optional<Message> try_receive() override { return boxes_.take(rank_); }

 private:
  Mailboxes& boxes_;
  int rank_;
};

stats::Tally kernel(TrialBlock block) {
  return {.trials = static_cast<std::uint64_t>(block.count),
          .moments = stats::Moments::of(test::normal_draws(random::Stream(7, 0), block.first, block.count, 2))};
}

/// Rank 0 does `lead`, the others serve; returns their exit codes.
std::vector<int> with_ranks(int ranks, const std::function<Share(const BlockOrder&, int)>& share_of,
                            const std::function<void(Workers&)>& lead) {
  Mailboxes boxes(ranks);
  std::vector<int> exits(static_cast<std::size_t>(ranks) - 1, -1);
  std::vector<std::thread> others;
  for (int r = 1; r < ranks; ++r)
    others.emplace_back([&, r] {
      ThreadMessages messages(boxes, r);
      exits[static_cast<std::size_t>(r) - 1] = serve(messages, [&](const BlockOrder& o) { return share_of(o, r); });
    });
  ThreadMessages own(boxes, 0);
  Workers workers(&own);
  try {
    lead(workers);
  } catch (...) {
    workers.end(70);
    for (std::thread& t : others) t.join();
    throw;
  }
  workers.end(0);
  for (std::thread& t : others) t.join();
  return exits;
}

Share share(std::uint64_t trials, BlockKernel k = kernel) {
  Share s{trials, std::move(k), {}};
  s.options.threads = 2;
  return s;
}

}  // namespace

TEST_CASE("Blocks are divided evenly, whatever is done already", "[workers]") {
  const std::vector<BlockRange> left = gaps({2, 20}, {{0, 3}, {5, 6}, {10, 12}, {19, 40}});
  REQUIRE(left.size() == 3);
  CHECK(count_of(left) == 13);
  const auto shares = divided(left, 4);
  std::vector<std::uint64_t> blocks;
  for (const auto& s : shares) {
    CHECK(count_of(s) >= 3);
    CHECK(count_of(s) <= 4);
    for (const BlockRange& r : s)
      for (std::uint64_t b = r.first; b < r.end; ++b) blocks.push_back(b);
  }
  CHECK(blocks == std::vector<std::uint64_t>{3, 4, 6, 7, 8, 9, 12, 13, 14, 15, 16, 17, 18});
  CHECK(divided({}, 3).size() == 3);
  CHECK(count_of(divided({{0, 2}}, 5)[4]) + count_of(divided({{0, 2}}, 5)[0]) <= 2);
}

TEST_CASE("Any number of ranks gives the bits of one, with a stopping rule and after an interruption, too",
          "[workers]") {
  constexpr std::uint64_t kTrials = 30001;
  const StoppingRule rule{{1024, 4096, 16384}, [](const stats::Tally& t) { return t.trials < 4096 ? 9000u : 16384u; }};
  const std::string whole = stats::tally_to_bytes(run_blocks(kTrials, kernel, {1}));
  const std::string ended = stats::tally_to_bytes(run_blocks(kTrials, kernel, {1}, rule));
  for (const int ranks : {1, 2, 3, 5}) {
    const auto exits = with_ranks(
        ranks, [&](const BlockOrder& o, int) { return share(o.point == 4 ? kTrials : 0); },
        [&](Workers& workers) {
          RunOptions options{.threads = 2, .workers = &workers, .point = 4};
          CHECK(stats::tally_to_bytes(run_blocks(kTrials, kernel, options)) == whole);
          CHECK(stats::tally_to_bytes(run_blocks(kTrials, kernel, options, rule)) == ended);
          std::vector<Subtree> kept = run_block_range(kTrials, {7, 30}, kernel, options);
          CHECK(stats::tally_to_bytes(run_blocks(kTrials, kernel, options, {}, kept)) == whole);
          std::atomic<bool> stop = false;
          options.stop = &stop;
          options.progress = [&](std::uint64_t, std::uint64_t) { stop = true; };
          kept.clear();
          options.save = [&](OrderedMerge& m) { m.take_unsaved([&](const Subtree& s) { kept.push_back(s); }); };
          CHECK_THROWS_AS(run_blocks(100 * kTrials, kernel, options), Interrupted);
          CHECK_FALSE(kept.empty());
        });
    for (const int e : exits) CHECK(e == 0);
  }
}

TEST_CASE("What a slow rank does not do in time, the others do", "[workers]") {
  // Rank 1 ends no block before rank 0 has done 70 of 100: with equal shares, neither would ever end.
  constexpr std::uint64_t kTrials = 100 * kBlockTrials;
  std::atomic<int> done_by_rank_0 = 0;
  std::atomic<bool> is_stuck = false;
  const auto slow = [&](TrialBlock b) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (done_by_rank_0 < 70 && !is_stuck) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (std::chrono::steady_clock::now() > end) is_stuck = true;
    }
    return kernel(b);
  };
  const auto fast = [&](TrialBlock b) {
    ++done_by_rank_0;
    return kernel(b);
  };
  with_ranks(
      2, [&](const BlockOrder&, int) { return share(kTrials, slow); },
      [&](Workers& workers) {
        CHECK(stats::tally_to_bytes(run_blocks(kTrials, fast, {.threads = 1, .workers = &workers})) ==
              stats::tally_to_bytes(run_blocks(kTrials, kernel, {1})));
      });
  CHECK_FALSE(is_stuck);
  CHECK(done_by_rank_0 < 100);  // rank 1 had some
}

// montecarlo_tests "[workers_gain]": seconds with one rank of four slowed, and what equal shares would take.
TEST_CASE("Time of a run with a slow rank, measured", "[.][workers_gain]") {
  constexpr int kRanks = 4, kBlocks = 400;
  constexpr auto kOneBlock = std::chrono::milliseconds(5);  // asleep, so that other load of the machine counts little
  const auto lasting = [&](int times) {
    return [=](TrialBlock b) {
      std::this_thread::sleep_for(times * kOneBlock);
      return kernel(b);
    };
  };
  for (const int times : {1, 2, 4, 10}) {
    const auto begin = std::chrono::steady_clock::now();
    with_ranks(
        kRanks,
        [&](const BlockOrder&, int rank) {
          Share s = share(kBlocks * kBlockTrials, lasting(rank == 1 ? times : 1));
          s.options.threads = 1;
          return s;
        },
        [&](Workers& workers) { run_blocks(kBlocks * kBlockTrials, lasting(1), {.threads = 1, .workers = &workers}); });
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    const double one = std::chrono::duration<double>(kOneBlock).count(), equal = kBlocks / kRanks * times * one;
    const double least = kBlocks * one / (kRanks - 1 + 1.0 / times);
    std::printf("one of %d ranks %2d times as slow: %.2f s; equal shares %.2f s at least; no less than %.2f s\n",
                kRanks, times, taken.count(), equal, least);
    CHECK(taken.count() >= least);
  }
}

TEST_CASE("Pieces of a queue are all of its blocks, once", "[workers]") {
  for (const std::uint64_t takers : {1u, 2u, 7u}) {
    BlockQueue queue({{3, 5}, {8, 9}, {20, 60}});
    std::vector<std::uint64_t> blocks;
    while (queue.left() > 0) {
      const std::uint64_t before = queue.left();
      const std::vector<BlockRange> piece = queue.take_piece(1.0 / static_cast<double>(takers), 4);
      REQUIRE(count_of(piece) > 0);
      CHECK(count_of(piece) <= (before + takers - 1) / takers);
      CHECK(queue.left() == before - count_of(piece));
      for (const BlockRange& r : piece)
        for (std::uint64_t b = r.first; b < r.end; ++b) blocks.push_back(b);
      if (const auto one = queue.take()) blocks.push_back(*one);
    }
    CHECK_FALSE(queue.take());
    std::vector<std::uint64_t> all{3, 4, 8};
    for (std::uint64_t b = 20; b < 60; ++b) all.push_back(b);
    CHECK(blocks == all);
  }
}

TEST_CASE("The error of one rank ends all, and keeps its kind", "[workers]") {
  const auto fails = [](const BlockOrder&, int rank) {
    return share(1u << 30, [rank](TrialBlock b) -> stats::Tally {
      if (rank == 2 && b.first % 8192 == 0) throw IoError("no disk");
      return kernel(b);
    });
  };
  const auto lead = [](Workers& workers) { run_blocks(1u << 30, kernel, {.threads = 2, .workers = &workers}); };
  CHECK_THROWS_AS(with_ranks(3, fails, lead), IoError);
  CHECK_THROWS_WITH(with_ranks(3, fails, lead), "rank 2: no disk");
  const auto refuses = [](const BlockOrder&, int) -> Share { throw InputError("no such file"); };
  CHECK_THROWS_AS(with_ranks(2, refuses, lead), InputError);
  const auto works = [](const BlockOrder&, int) { return share(1u << 30); };
  CHECK_THROWS_AS(with_ranks(3, works,
                             [](Workers& workers) {
                               run_blocks(1u << 30, [](TrialBlock) -> stats::Tally { throw std::domain_error("ours"); },
                                          {.threads = 1, .workers = &workers});
                             }),
                  std::domain_error);
}

TEST_CASE("A rank that is told to stop stops all", "[workers]") {
  std::atomic<bool> stop = false;
  const auto share_of = [&](const BlockOrder&, int rank) {
    Share s = share(1u << 30);
    if (rank == 1) s.options.stop = &stop;
    return s;
  };
  CHECK_THROWS_AS(with_ranks(3, share_of,
                             [&](Workers& workers) {
                               const auto progress = [&](std::uint64_t, std::uint64_t) { stop = true; };
                               run_blocks(1u << 30, kernel, {.threads = 1, .progress = progress, .workers = &workers});
                             }),
                  Interrupted);
}
