#pragma once
/// Trials are run in blocks of fixed size. Who computes a block does not change its bits.
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

/// Called from several threads; must not change what it shares.
using BlockKernel = std::function<stats::Tally(TrialBlock)>;

/// Blocks of a run: first .. end - 1.
struct BlockRange {
  std::uint64_t first = 0, end = 0;
};

/// All blocks of so many trials.
inline BlockRange all_blocks(std::uint64_t trials, int block_trials = kBlockTrials) {
  const auto size = static_cast<std::uint64_t>(block_trials);
  return {0, (trials + size - 1) / size};
}

/// How many of `trials` are in these blocks.
inline std::uint64_t trials_in(BlockRange blocks, std::uint64_t trials, int block_trials) {
  const auto size = static_cast<std::uint64_t>(block_trials);
  return std::min(blocks.end * size, trials) - std::min(blocks.first * size, trials);
}

/// Blocks of `all` that are in none of `covered`; both rising and apart.
std::vector<BlockRange> gaps(BlockRange all, const std::vector<BlockRange>& covered);

/// `blocks` in `shares` lists of as many blocks each as can be, in order. Each list is rising and apart, as `blocks`
/// is.
std::vector<std::vector<BlockRange>> divided(const std::vector<BlockRange>& blocks, std::size_t shares);

std::uint64_t count_of(const std::vector<BlockRange>& blocks);

/// What compute_blocks does, and with how many threads (0: all that the machine offers).
struct BlockWork {
  std::vector<BlockRange> blocks;  ///< rising, apart
  std::uint64_t trials = 0;        ///< of the whole run
  int block_trials = kBlockTrials, threads = 0;
};

/// kernel(block) of every block in parallel; take(number, tally) gets them as they come, one at a time. The first
/// exception of either is rethrown after all threads have stopped. False if `stopped` ended it before the last block
/// was begun; asked from several threads. The only OpenMP.
bool compute_blocks(const BlockWork& work, const BlockKernel& kernel, const std::function<bool()>& stopped,
                    const std::function<void(std::uint64_t, stats::Tally)>& take);

/// What `threads = 0` means here.
int available_threads();

}  // namespace surveymc::montecarlo
