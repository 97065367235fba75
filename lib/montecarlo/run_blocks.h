#pragma once
/// Computes and merges the blocks of a run, from threads, other ranks and earlier attempts, so that the bits do not
/// depend on which of them computed a block.
#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/shared_work.h"
#include "montecarlo/blocks.h"
#include "montecarlo/ordered_merge.h"

namespace surveymc::montecarlo {

class Workers;

struct RunOptions {
  int threads = 0;  ///< 0: all that the machine offers
  /// Trials done so far and expected in all; called by one thread at a time.
  std::function<void(std::uint64_t, std::uint64_t)> progress = {};
  const std::atomic<bool>* stop = nullptr;  ///< set: no new block is begun; Interrupted is thrown if any is left
  int block_trials = kBlockTrials;          ///< fewer in a study of few long trials; results depend on this number
  /// Asked after each block whether it is time to call `save`; by one thread at a time.
  std::function<bool()> save_due = {};
  /// Called with the merge whenever save_due returns true, and before run_blocks returns or throws Interrupted.
  /// take_unsaved() of the merge then gives every block that was finished since the last call.
  std::function<void(OrderedMerge&)> save = {};
  Workers* workers = nullptr;    ///< other ranks that share the blocks; they know the kernel by
  std::uint64_t point = 0;       ///< this number
  SharedWork* shared = nullptr;  ///< what preparing other points of the task has made; null: nothing is shared
};

/// Ends a run early: at each look (a rising number of trials, whole blocks) `needed` predicts from the trials so far
/// how many are needed in all; the run ends when there are as many. Looks do not depend on threads, so neither does the
/// number of trials at the end.
struct StoppingRule {
  std::vector<std::uint64_t> looks = {};
  std::function<std::uint64_t(const stats::Tally&)> needed = {};
};

/// kernel(block) for trials 0 .. trials - 1, or until `rule` ends the run, merged: the same bits as a run of just as
/// many trials without a rule. The first exception of a kernel is rethrown after all threads have stopped.
/// `finished` are subtrees of an earlier run of the same trials, kernel and rule, which are not computed again; those
/// that have another number of trials than their blocks are left out.
stats::Tally run_blocks(std::uint64_t trials, const BlockKernel& kernel, const RunOptions& options,
                        const StoppingRule& rule = {}, std::vector<Subtree> finished = {});

/// The blocks `range` of these trials as subtrees, in order of the blocks. Subtrees of `finished` count if they lie
/// within the range.
std::vector<Subtree> run_block_range(std::uint64_t trials, BlockRange range, const BlockKernel& kernel,
                                     const RunOptions& options, std::vector<Subtree> finished = {});

}  // namespace surveymc::montecarlo
