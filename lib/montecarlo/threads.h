#pragma once
/// All parallel computation goes through these functions. A run has one parallel region of OpenMP, whose threads share
/// the points of a sweep and the blocks of each point. OMP_NUM_THREADS, OMP_THREAD_LIMIT, OMP_PROC_BIND, OMP_PLACES and
/// OMP_STACKSIZE mean what OpenMP says. Idle threads sleep: LLVM's runtime is told so here, GCC's needs
/// OMP_WAIT_POLICY=passive in the environment.
#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace surveymc::montecarlo {

/// The number of threads that `threads = 0` means here.
int available_threads();

/// `threads`, or where that is 0 available_threads(); at most as many as there is work, and at least one.
int threads_for(int threads, std::size_t work);

/// Calls next(share) again and again for each share = 0 .. threads - 1 (0: available_threads()), the shares in
/// parallel, until next() returns false or stopped() returns true. One share is never in two threads at a time. The
/// first exception is rethrown when all shares have ended. Called by compute() of in_order(), it uses the threads that
/// are there and idle.
void in_threads(int threads, const std::function<bool()>& stopped, const std::function<bool(int share)>& next);

/// The number of items that are computed, or wait to be taken, at a time. More hide long items better, and take more
/// memory.
inline std::size_t most_in_flight(int threads) { return 4 * static_cast<std::size_t>(threads); }

/// Calls compute(i, place) for i = 0 .. count - 1 in parallel, begun in this order, and take(i, place) exactly in this
/// order and one at a time. `place` = 0 .. most_in_flight(threads) - 1 belongs to the item until it is taken. After an
/// exception of either no further item is begun. The exception of the lowest item is rethrown: the one that a loop
/// would have thrown. Not called inside itself.
void in_order(std::size_t count, int threads, const std::function<void(std::size_t i, std::size_t place)>& compute,
              const std::function<void(std::size_t i, std::size_t place)>& take);

/// take(i, compute(i)) by in_order(); with one thread it is just this loop.
template <class Compute, class Take>
void compute_in_order(std::size_t count, int threads, const Compute& compute, const Take& take) {
  if (threads == 1 || count <= 1) {
    for (std::size_t i = 0; i < count; ++i) take(i, compute(i));
    return;
  }
  std::vector<std::optional<decltype(compute(std::size_t{}))>> results(std::min(count, most_in_flight(threads)));
  in_order(
      count, threads, [&](std::size_t i, std::size_t place) { results[place].emplace(compute(i)); },
      [&](std::size_t i, std::size_t place) {
        take(i, std::move(*results[place]));
        results[place].reset();
      });
}

}  // namespace surveymc::montecarlo
