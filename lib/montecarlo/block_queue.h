#pragma once
/// Blocks that wait to be computed. Free threads and ranks take them in pieces, so that a slow one does not decide how
/// long a run takes. Which of them computes a block changes no bit (ordered_merge.h).
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <vector>

#include "montecarlo/blocks.h"

namespace surveymc::montecarlo {

/// Called by several threads.
class BlockQueue {
 public:
  /// `blocks`: rising, without overlap.
  explicit BlockQueue(std::vector<BlockRange> blocks) : open_(std::move(blocks)), left_(count_of(open_)) {}

  /// The next block; none if there is none.
  std::optional<std::uint64_t> take();

  /// The next piece for a taker that does `share` (above 0, at most 1) of the work: a quarter of its share of what is
  /// left; `least` blocks if that is more, but not above its share, nor above `most`. So pieces become smaller towards
  /// the end, and all takers end at about the same time. Empty if nothing is left.
  std::vector<BlockRange> take_piece(double share, std::uint64_t least,
                                     std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

  std::uint64_t left() const;

 private:
  std::vector<BlockRange> take_first(std::uint64_t count);  // with the lock held

  mutable std::mutex taking_;
  std::vector<BlockRange> open_;
  std::size_t next_ = 0;  // in open_
  std::uint64_t left_ = 0;
};

/// As compute_blocks() of a list, with blocks from where other takers have theirs. False if `stopped` ended the work
/// while there were blocks.
bool compute_blocks(BlockQueue& queue, const BlockWork& work, const BlockKernel& kernel,
                    const std::function<bool()>& stopped, const std::function<void(std::uint64_t, stats::Tally)>& take);

}  // namespace surveymc::montecarlo
