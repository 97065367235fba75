#include "montecarlo/run_blocks.h"

#include <deque>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "montecarlo/block_queue.h"
#include "montecarlo/workers.h"

namespace surveymc::montecarlo {
namespace {

/// Gives blocks of a queue to other ranks as fast as each of them has been so far. Every rank begins with the least
/// piece, so that a slow one never has much that others wait for.
class BlockDispatcher {
 public:
  BlockDispatcher(BlockQueue& queue, const RunOptions& options)
      : queue_(queue), options_(options), all_(queue.left()), ranks_(options.workers ? options.workers->count() : 0) {}

  void begin() {
    const std::uint64_t least = options_.workers->least_piece();
    for (std::size_t w = 0; w < ranks_.size(); ++w) order(w, least);
    // A second order each, which is there when the first is done; if there is enough for rank 0, too.
    if (queue_.left() > 2 * (1 + ranks_.size()) * least)
      for (std::size_t w = 0; w < ranks_.size(); ++w) order(w, least);
  }

  /// The rank has done the first of its orders.
  void next(std::size_t worker) {
    Rank& rank = ranks_[worker];
    rank.done += rank.orders.front();
    rank.orders.pop_front();
    order(worker, std::numeric_limits<std::uint64_t>::max());
  }

 private:
  struct Rank {
    std::deque<std::uint64_t> orders;  // their blocks, without an answer
    std::uint64_t done = 0;            // blocks
  };

  void order(std::size_t worker, std::uint64_t most) {
    const std::uint64_t least = options_.workers->least_piece();
    std::uint64_t ordered = 0;
    for (const Rank& rank : ranks_) ordered = std::accumulate(rank.orders.begin(), rank.orders.end(), ordered);
    const std::uint64_t by_all = all_ - queue_.left() - ordered;  // rank 0 takes from the queue what it computes
    // As if each rank had done the least piece before: equal shares at the beginning.
    const double share =
        static_cast<double>(ranks_[worker].done + least) / static_cast<double>(by_all + (1 + ranks_.size()) * least);
    const std::vector<BlockRange> piece = queue_.take_piece(share, least, most);
    if (piece.empty()) return;
    ranks_[worker].orders.push_back(count_of(piece));
    options_.workers->order(options_.point, worker, piece);
  }

  BlockQueue& queue_;
  const RunOptions& options_;
  std::uint64_t all_;
  std::vector<Rank> ranks_;  // but rank 0
};

/// One run: computes blocks in parallel up to a block number, again and again for each look of a stopping rule.
class BlockRun {
 public:
  BlockRun(std::uint64_t trials, std::uint64_t first, const BlockKernel& kernel, const RunOptions& options,
           std::vector<Subtree> finished)
      : trials_(trials), next_(first), expected_(trials), kernel_(kernel), options_(options) {
    const std::uint64_t blocks = all_blocks(trials, options.block_trials).end;
    std::erase_if(finished, [&](const Subtree& n) {
      return n.end_block() > blocks ||
             n.tally.trials != trials_in({n.first_block(), n.end_block()}, trials, options.block_trials);
    });
    for (Subtree& node : disjoint_subtrees(std::move(finished))) {
      covered_.push_back({node.first_block(), node.end_block()});
      done_ += node.tally.trials;
      merge_.add(std::move(node), true);
    }
  }

  void until(std::uint64_t end_block) {
    BlockQueue queue(gaps({next_, end_block}, covered_));
    next_ = end_block;
    BlockDispatcher dispatcher(queue, options_);
    const std::function<void(std::size_t)> hand_on = [&](std::size_t worker) { dispatcher.next(worker); };
    if (options_.workers) dispatcher.begin();
    bool whole = false;
    try {
      whole = compute_blocks(
          queue, {{}, trials_, options_.block_trials, options_.threads}, kernel_, [&] { return stopped(); },
          [&](std::uint64_t block, stats::Tally tally) {
            done_ += tally.trials;
            merge_.add(block, std::move(tally));
            if (options_.workers && options_.workers->poll(hand_on)) other_stopped_ = true;
            if (options_.workers) add(options_.workers->taken());
            if (options_.progress) options_.progress(std::min(done_, expected_), expected_);
            if (options_.save && options_.save_due && options_.save_due()) options_.save(merge_);
          });
    } catch (...) {
      drop_others();
      throw;
    }
    if (collect(whole, hand_on) && whole) return;
    save_rest();
    throw Interrupted("stopped before all trials were done");
  }

  void save_rest() {
    if (options_.save) options_.save(merge_);
  }
  void expect(std::uint64_t trials) { expected_ = trials; }
  /// End of the last block that an earlier run has finished.
  std::uint64_t reached() const { return covered_.empty() ? 0 : covered_.back().end; }
  OrderedMerge& merged() { return merge_; }

 private:
  bool stopped() const { return other_stopped_ || (options_.stop && *options_.stop); }

  void add(std::vector<Subtree> nodes) {
    for (Subtree& n : nodes) {
      done_ += n.tally.trials;
      merge_.add(std::move(n), false);
    }
  }

  /// Waits for the other ranks, telling them to stop if our own blocks are not `whole`. True if their orders are whole.
  bool collect(bool whole, const std::function<void(std::size_t)>& hand_on) {
    if (!options_.workers) return true;
    if (!whole) options_.workers->stop();
    Workers::Work work = options_.workers->collect([&] { return stopped(); }, hand_on);
    add(std::move(work.subtrees));
    return !work.cut_short;
  }

  /// Our own error is reported, and not those of other ranks that follow from telling them to stop.
  void drop_others() {
    try {
      collect(false, [](std::size_t) {});
    } catch (const std::exception&) {
    }
  }

  std::uint64_t trials_, next_, expected_, done_ = 0;
  const BlockKernel& kernel_;
  const RunOptions& options_;
  std::atomic<bool> other_stopped_ = false;
  std::vector<BlockRange> covered_;  // rising, apart
  OrderedMerge merge_;
};

}  // namespace

stats::Tally run_blocks(std::uint64_t trials, const BlockKernel& kernel, const RunOptions& options,
                        const StoppingRule& rule, std::vector<Subtree> finished) {
  BlockRun run(trials, 0, kernel, options, std::move(finished));
  for (const std::uint64_t look : rule.looks) {
    // A block after a look was begun because the look did not end the run. It need not be added again, and cannot be,
    // because the tree may have merged across the look.
    const std::uint64_t end = all_blocks(std::min(look, trials), options.block_trials).end;
    if (end < run.reached()) continue;
    run.until(end);
    stats::Tally so_far = run.merged().whole();
    const std::uint64_t needed = std::min(std::max(rule.needed(so_far), so_far.trials), trials);
    run.expect(needed);
    if (needed > so_far.trials) continue;
    run.save_rest();
    return so_far;
  }
  run.until(all_blocks(trials, options.block_trials).end);
  run.save_rest();
  return run.merged().whole();
}

std::vector<Subtree> run_block_range(std::uint64_t trials, BlockRange range, const BlockKernel& kernel,
                                     const RunOptions& options, std::vector<Subtree> finished) {
  std::erase_if(finished, [&](const Subtree& n) { return n.first_block() < range.first || n.end_block() > range.end; });
  BlockRun run(trials, range.first, kernel, options, std::move(finished));
  run.expect(trials_in(range, trials, options.block_trials));
  run.until(range.end);
  run.save_rest();
  return run.merged().take();
}

}  // namespace surveymc::montecarlo
