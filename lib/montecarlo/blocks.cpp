#include "montecarlo/blocks.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "montecarlo/block_queue.h"
#include "montecarlo/threads.h"

namespace surveymc::montecarlo {

std::vector<BlockRange> gaps(BlockRange all, const std::vector<BlockRange>& covered) {
  std::vector<BlockRange> left;
  std::uint64_t reached = all.first;
  for (const BlockRange& c : covered) {
    if (c.first > reached && reached < all.end) left.push_back({reached, std::min(c.first, all.end)});
    reached = std::max(reached, c.end);
  }
  if (reached < all.end) left.push_back({reached, all.end});
  return left;
}

std::uint64_t count_of(const std::vector<BlockRange>& blocks) {
  std::uint64_t n = 0;
  for (const BlockRange& r : blocks) n += r.end - r.first;
  return n;
}

std::vector<std::vector<BlockRange>> divided(const std::vector<BlockRange>& blocks, std::size_t shares) {
  const std::uint64_t all = count_of(blocks);
  std::vector<std::vector<BlockRange>> lists(shares);
  std::uint64_t before = 0;  // blocks in front of the range
  for (const BlockRange& r : blocks) {
    for (std::size_t s = 0; s < shares; ++s) {
      const std::uint64_t begin = std::max(all * s / shares, before),
                          end = std::min(all * (s + 1) / shares, before + (r.end - r.first));
      if (begin < end) lists[s].push_back({r.first + (begin - before), r.first + (end - before)});
    }
    before += r.end - r.first;
  }
  return lists;
}

std::vector<BlockRange> BlockQueue::take_first(std::uint64_t count) {
  std::vector<BlockRange> piece;
  while (count > 0 && next_ < open_.size()) {
    BlockRange& range = open_[next_];
    const std::uint64_t n = std::min(count, range.end - range.first);
    if (n > 0) piece.push_back({range.first, range.first + n});
    range.first += n;
    count -= n;
    left_ -= n;
    if (range.first == range.end) ++next_;
  }
  return piece;
}

std::optional<std::uint64_t> BlockQueue::take() {
  const std::scoped_lock lock(taking_);
  const std::vector<BlockRange> one = take_first(1);
  return one.empty() ? std::nullopt : std::optional(one.front().first);
}

std::vector<BlockRange> BlockQueue::take_piece(double share, std::uint64_t least, std::uint64_t most) {
  const std::scoped_lock lock(taking_);
  const auto own = static_cast<std::uint64_t>(std::ceil(static_cast<double>(left_) * share));
  return take_first(std::min(most, std::max(own / 4, std::min(least, own))));
}

std::uint64_t BlockQueue::left() const {
  const std::scoped_lock lock(taking_);
  return left_;
}

bool compute_blocks(const BlockWork& work, const BlockKernel& kernel, const std::function<bool()>& stopped,
                    const std::function<void(std::uint64_t, stats::Tally)>& take) {
  BlockQueue queue(work.blocks);
  return compute_blocks(queue, work, kernel, stopped, take);
}

bool compute_blocks(BlockQueue& queue, const BlockWork& work, const BlockKernel& kernel,
                    const std::function<bool()>& stopped,
                    const std::function<void(std::uint64_t, stats::Tally)>& take) {
  const auto size = static_cast<std::uint64_t>(work.block_trials);
  std::mutex taking;
  in_threads(threads_for(work.threads, queue.left()), stopped, [&](int) {
    const std::optional<std::uint64_t> block = queue.take();
    if (!block) return false;
    const std::uint64_t first = *block * size;
    stats::Tally tally = kernel({first, static_cast<int>(std::min(size, work.trials - first))});
    const std::scoped_lock lock(taking);
    take(*block, std::move(tally));
    return true;
  });
  return queue.left() == 0;
}

}  // namespace surveymc::montecarlo
