#include "montecarlo/threads.h"

#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

namespace surveymc::montecarlo {
namespace {

/// Later items are done first.
void wait_for(std::size_t i) { std::this_thread::sleep_for(std::chrono::microseconds(i % 3 == 0 ? 500 : 0)); }

}  // namespace

TEST_CASE("Items are taken in order and one at a time, and no more are in flight than there are places") {
  for (const int threads : {1, 2, 3, 8}) {
    CAPTURE(threads);
    constexpr std::size_t kItems = 200;
    std::vector<std::size_t> taken;
    std::atomic<std::size_t> begun = 0, ended = 0;
    std::atomic<bool> is_taking = false, overlaps = false, too_many = false;
    compute_in_order(
        kItems, threads,
        [&](std::size_t i) {
          if (++begun - ended > most_in_flight(threads)) too_many = true;
          wait_for(i);
          return 3 * i;
        },
        [&](std::size_t i, std::size_t result) {
          if (is_taking.exchange(true) || result != 3 * i) overlaps = true;
          taken.push_back(i);
          ++ended;
          is_taking = false;
        });
    std::vector<std::size_t> all(kItems);
    std::iota(all.begin(), all.end(), std::size_t{0});
    CHECK(taken == all);
    CHECK_FALSE(overlaps);
    CHECK_FALSE(too_many);
  }
}

TEST_CASE("The exception of the lowest item is thrown, as by a loop, and nothing behind it is taken") {
  for (const int threads : {1, 2, 5}) {
    CAPTURE(threads);
    std::vector<std::size_t> taken;
    const auto run = [&] {
      compute_in_order(
          1000, threads,
          [](std::size_t i) {
            wait_for(i);
            if (i >= 21) throw std::runtime_error("item " + std::to_string(i));
            return i;
          },
          [&](std::size_t i, std::size_t) { taken.push_back(i); });
    };
    CHECK_THROWS_WITH(run(), "item 21");
    CHECK(taken.size() == 21);
    taken.clear();
    const auto refuse = [&] {
      compute_in_order(
          1000, threads, [](std::size_t i) { return i; },
          [&](std::size_t i, std::size_t) {
            if (i == 7) throw std::runtime_error("taking " + std::to_string(i));
            taken.push_back(i);
          });
    };
    CHECK_THROWS_WITH(refuse(), "taking 7");
    CHECK(taken.size() == 7);
  }
}

TEST_CASE("Inside an item its work is shared by idle threads, each share in one thread at a time") {
  constexpr int kThreads = 4, kPieces = 400;
  std::atomic<bool> overlaps = false;
  std::vector<int> sums;
  compute_in_order(
      3, kThreads,
      [&](std::size_t) {
        std::atomic<int> next = 0, done = 0;
        std::array<std::atomic<bool>, kThreads> is_running{};
        in_threads(
            kThreads, [] { return false; },
            [&](int share) {
              if (is_running[static_cast<std::size_t>(share)].exchange(true)) overlaps = true;
              const bool is_mine = next++ < kPieces;
              if (is_mine) ++done;
              is_running[static_cast<std::size_t>(share)] = false;
              return is_mine;
            });
        return done.load();
      },
      [&](std::size_t, int done) { sums.push_back(done); });
  CHECK(sums == std::vector<int>(3, kPieces));
  CHECK_FALSE(overlaps);
}

TEST_CASE("One long item among short ones is computed by more than one thread") {
  std::set<std::thread::id> helpers;
  std::mutex adding;
  compute_in_order(
      2, 2,
      [&](std::size_t i) {
        if (i == 1) return 0;
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        in_threads(
            2, [] { return false; },
            [&](int) {
              const std::scoped_lock lock(adding);
              helpers.insert(std::this_thread::get_id());
              return helpers.size() < 2 && std::chrono::steady_clock::now() < end;
            });
        return 0;
      },
      [](std::size_t, int) {});
  CHECK(helpers.size() == 2);
}

TEST_CASE("Each share is called, whether or not a thread is idle") {
  for (const int items : {1, 2, 50}) {
    std::atomic<int> calls = 0;
    compute_in_order(
        static_cast<std::size_t>(items), 2,
        [&](std::size_t) {
          in_threads(
              3, [] { return false; }, [&](int share) { return (calls += 1 << (8 * share)), false; });
          return 0;
        },
        [](std::size_t, int) {});
    CHECK(calls == items * 0x010101);
  }
}

TEST_CASE("An exception of one share ends the others") {
  for (const bool is_inside : {false, true}) {
    const auto work = [] {
      std::atomic<int> calls = 0;
      in_threads(
          3, [] { return false; },
          [&](int) -> bool {
            if (++calls == 5) throw std::runtime_error("fifth");
            return true;
          });
    };
    if (is_inside)
      CHECK_THROWS_WITH(compute_in_order(
                            4, 2,
                            [&](std::size_t) {
                              work();
                              return 0;
                            },
                            [](std::size_t, int) {}),
                        "fifth");
    else
      CHECK_THROWS_WITH(work(), "fifth");
  }
}

TEST_CASE("There are no more threads than work, and at least one") {
  CHECK(threads_for(8, 3) == 3);
  CHECK(threads_for(8, 0) == 1);
  CHECK(threads_for(2, 100) == 2);
  CHECK(threads_for(0, 1'000'000) == available_threads());
}

}  // namespace surveymc::montecarlo
