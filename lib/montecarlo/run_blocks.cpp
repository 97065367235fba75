#include "montecarlo/run_blocks.h"

#include <algorithm>
#include <exception>

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

Tally OrderedMerge::finish() {
  // Without gaps the complete subtrees left over have falling levels from left to right.
  Tally whole;
  for (auto node = waiting_.rbegin(); node != waiting_.rend(); ++node) whole.merge(node->second);
  waiting_.clear();
  return whole;
}

int available_threads() { return omp_get_max_threads(); }

Tally run_blocks(std::uint64_t trials, const std::function<Tally(TrialBlock)>& kernel, const RunOptions& options) {
  constexpr std::uint64_t size = kBlockTrials;
  const auto blocks = static_cast<std::int64_t>((trials + size - 1) / size);
  const int threads = options.threads > 0 ? options.threads : available_threads();
  OrderedMerge merge;
  std::uint64_t done = 0;
  std::exception_ptr error;
  std::atomic<bool> abandon = false;
  std::atomic<std::int64_t> next = 0;  // our own dynamic schedule: a stop leaves the loop, however many blocks remain
#pragma omp parallel num_threads(threads)
  while (!abandon && !(options.stop && *options.stop)) {
    const std::int64_t b = next++;
    if (b >= blocks) break;
    try {
      const std::uint64_t first = static_cast<std::uint64_t>(b) * size;
      const TrialBlock block{first, static_cast<int>(std::min(size, trials - first))};
      Tally tally = kernel(block);
#pragma omp critical(surveymc_run_blocks)
      {
        merge.add(static_cast<std::uint64_t>(b), std::move(tally));
        done += static_cast<std::uint64_t>(block.count);
        if (options.progress) options.progress(done);
      }
    } catch (...) {
      abandon = true;
#pragma omp critical(surveymc_run_blocks)
      if (!error) error = std::current_exception();
    }
  }
  if (error) std::rethrow_exception(error);
  if (options.stop && *options.stop) throw Interrupted("stopped before all trials were done");
  return merge.finish();
}

}  // namespace surveymc
