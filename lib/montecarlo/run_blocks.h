#pragma once
/// Blocks of trials in parallel, merged so that the bits do not depend on who computed what. The only OpenMP.
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "stats/tally.h"

namespace surveymc {

/// Trials first .. first + count - 1. `first` is a multiple of the trials per block.
struct TrialBlock {
  std::uint64_t first = 0;
  int count = 0;
};

/// Trials per block. Part of every archived result: another size would sum in another order.
inline constexpr int kBlockTrials = 512;

/// Merges block tallies along a fixed binary tree over the block number, in whatever order they arrive: node
/// (level, i) holds blocks i 2^level .. (i + 1) 2^level - 1. Holds a few tallies per level at a time, not one per
/// block.
class OrderedMerge {
 public:
  void add(std::uint64_t block, Tally tally);
  /// The whole of blocks 0 .. n - 1, all of which have been added. What has no sibling at the right end is merged from
  /// left to right. More blocks may be added afterwards.
  Tally whole() const;

 private:
  std::map<std::pair<int, std::uint64_t>, Tally> waiting_;  // (level, index) whose sibling has not come yet
};

struct RunOptions {
  int threads = 0;  ///< 0: all that the machine offers
  /// Trials done so far and expected in all; called by one thread at a time.
  std::function<void(std::uint64_t, std::uint64_t)> progress = {};
  const std::atomic<bool>* stop = nullptr;  ///< set: no new block is begun and Interrupted is thrown
  int block_trials = kBlockTrials;          ///< a study of few long trials asks for less; part of its results
};

/// Ends a run early: at each look (a rising number of trials, whole blocks) `needed` predicts from the trials so far
/// how many are needed in all; the run ends when there are as many. Looks do not depend on threads, so neither does the
/// end.
struct StoppingRule {
  std::vector<std::uint64_t> looks = {};
  std::function<std::uint64_t(const Tally&)> needed = {};
};

/// kernel(block) for trials 0 .. trials - 1, or until `rule` ends the run, merged: the same bits as a run of just as
/// many trials without a rule. The first exception of a kernel is rethrown after all threads have stopped. kernel is
/// called from several threads and must not change what it shares.
Tally run_blocks(std::uint64_t trials, const std::function<Tally(TrialBlock)>& kernel, const RunOptions& options,
                 const StoppingRule& rule = {});

/// What `threads = 0` means here.
int available_threads();

}  // namespace surveymc
