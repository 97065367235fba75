#pragma once
/// Trials are run in blocks of fixed size. The bits of a block do not depend on the thread or rank that computes it.
#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "stats/tally.h"

namespace surveymc::montecarlo {

/// Trials first .. first + count - 1. `first` is a multiple of the trials per block.
struct TrialBlock {
  std::uint64_t first = 0;
  int count = 0;
};

/// Trials per block. Part of every archived result: another size would sum in another order.
inline constexpr int kBlockTrials = 512;

/// Called from several threads; must not change shared data.
using BlockKernel = std::function<stats::Tally(TrialBlock)>;

/// Blocks of a run: first .. end - 1.
struct BlockRange {
  std::uint64_t first = 0, end = 0;
};

/// All blocks of this number of trials.
inline BlockRange all_blocks(std::uint64_t trials, int block_trials = kBlockTrials) {
  const auto size = static_cast<std::uint64_t>(block_trials);
  return {0, (trials + size - 1) / size};
}

/// How many of `trials` are in these blocks.
inline std::uint64_t trials_in(BlockRange blocks, std::uint64_t trials, int block_trials) {
  const auto size = static_cast<std::uint64_t>(block_trials);
  return std::min(blocks.end * size, trials) - std::min(blocks.first * size, trials);
}

/// Blocks of `all` that are in none of `covered`; ranges of `covered` and of the result are rising and do not overlap.
std::vector<BlockRange> gaps(BlockRange all, const std::vector<BlockRange>& covered);

/// Divides `blocks` into `shares` lists with numbers of blocks as equal as possible, in order. As in `blocks`, the
/// ranges of each list are rising and do not overlap.
std::vector<std::vector<BlockRange>> divided(const std::vector<BlockRange>& blocks, std::size_t shares);

std::uint64_t count_of(const std::vector<BlockRange>& blocks);

/// The work of compute_blocks, and the number of threads (0: all that the machine offers).
struct BlockWork {
  std::vector<BlockRange> blocks;  ///< rising, without overlap
  std::uint64_t trials = 0;        ///< of the whole run
  int block_trials = kBlockTrials, threads = 0;
};

/// Calls kernel(block) for every block in parallel; take(number, tally) gets the tallies as they come, one at a time.
/// The first exception of either is rethrown after all threads have stopped. False if `stopped` ended the work before
/// the last block was begun; several threads call `stopped`.
bool compute_blocks(const BlockWork& work, const BlockKernel& kernel, const std::function<bool()>& stopped,
                    const std::function<void(std::uint64_t, stats::Tally)>& take);

}  // namespace surveymc::montecarlo
