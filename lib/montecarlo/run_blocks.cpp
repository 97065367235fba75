#include "montecarlo/run_blocks.h"

#include <algorithm>
#include <exception>
#include <mutex>

#include <omp.h>

#include "base/error.h"

namespace surveymc {

void OrderedMerge::add(std::uint64_t block, Tally tally) {
  int level = 0;
  for (;;) {
    const auto sibling = waiting_.find({level, block ^ 1});
    if (sibling == waiting_.end()) break;
    if (block % 2 == 0) {
      tally.merge(sibling->second);
    } else {
      sibling->second.merge(tally);
      tally = std::move(sibling->second);
    }
    waiting_.erase(sibling);
    block /= 2;
    ++level;
  }
  waiting_.emplace(std::pair{level, block}, std::move(tally));
}

Tally OrderedMerge::whole() const {
  // Without gaps the complete subtrees left over have falling levels from left to right.
  Tally sum;
  for (auto node = waiting_.rbegin(); node != waiting_.rend(); ++node) sum.merge(node->second);
  return sum;
}

int available_threads() { return omp_get_max_threads(); }

Tally run_blocks(std::uint64_t trials, const std::function<Tally(TrialBlock)>& kernel, const RunOptions& options,
                 const StoppingRule& rule) {
  const auto size = static_cast<std::uint64_t>(options.block_trials);
  const int threads = options.threads > 0 ? options.threads : available_threads();
  OrderedMerge merge;
  std::uint64_t done = 0, expected = trials;
  std::exception_ptr error;
  std::mutex merging;  // not omp critical: thread sanitizers see a mutex, and GCC's OpenMP they do not
  std::atomic<bool> abandon = false;
  std::atomic<std::uint64_t> next = 0;  // our own dynamic schedule: a stop leaves the loop, however many blocks remain

  const auto run_until = [&](std::uint64_t end) {
    const std::uint64_t blocks = (end + size - 1) / size;
#pragma omp parallel num_threads(threads)
    while (!abandon && !(options.stop && *options.stop)) {
      std::uint64_t b = next;
      do {
        if (b >= blocks) break;
      } while (!next.compare_exchange_weak(b, b + 1));
      if (b >= blocks) break;
      try {
        const TrialBlock block{b * size, static_cast<int>(std::min(size, trials - b * size))};
        Tally tally = kernel(block);
        const std::scoped_lock lock(merging);
        merge.add(b, std::move(tally));
        done += static_cast<std::uint64_t>(block.count);
        if (options.progress) options.progress(done, expected);
      } catch (...) {
        abandon = true;
        const std::scoped_lock lock(merging);
        if (!error) error = std::current_exception();
      }
    }
    const std::scoped_lock lock(merging);
    if (error) std::rethrow_exception(error);
    if (options.stop && *options.stop) throw Interrupted("stopped before all trials were done");
  };

  for (const std::uint64_t look : rule.looks) {
    run_until(std::min(look, trials));
    Tally so_far = merge.whole();
    expected = std::min(std::max(rule.needed(so_far), so_far.trials), trials);
    if (expected <= so_far.trials) return so_far;
  }
  run_until(trials);
  return merge.whole();
}

}  // namespace surveymc
