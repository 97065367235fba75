#pragma once
/// Blocks of trials in parallel, merged so that the bits do not depend on who computed what. The only OpenMP.
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>

#include "stats/tally.h"

namespace surveymc {

/// Trials first .. first + count - 1. `first` is a multiple of kBlockTrials.
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
  /// The whole. What has no sibling at the right end is merged from left to right.
  Tally finish();

 private:
  std::map<std::pair<int, std::uint64_t>, Tally> waiting_;  // (level, index) whose sibling has not come yet
};

struct RunOptions {
  int threads = 0;                                   ///< 0: all that the machine offers
  std::function<void(std::uint64_t)> progress = {};  ///< trials done so far; called by one thread at a time
  const std::atomic<bool>* stop = nullptr;           ///< set: no new block is begun and Interrupted is thrown
};

/// kernel(block) for trials 0 .. trials - 1, merged. The first exception of a kernel is rethrown after all threads
/// have stopped. kernel is called from several threads and must not change what it shares.
Tally run_blocks(std::uint64_t trials, const std::function<Tally(TrialBlock)>& kernel, const RunOptions& options);

/// What `threads = 0` means here.
int available_threads();

}  // namespace surveymc
