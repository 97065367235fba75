#include "montecarlo/run_blocks.h"

#include "base/error.h"
#include "montecarlo/workers.h"

namespace surveymc::montecarlo {
namespace {

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
    std::vector<std::vector<BlockRange>> shares = divide({next_, end_block});
    next_ = end_block;
    const std::vector<BlockRange> own = std::move(shares.front());
    shares.erase(shares.begin());
    const std::uint64_t of_all = count_of(own) == 0 ? 1 : 1 + total(shares) / count_of(own);  // for the progress
    if (options_.workers) options_.workers->order(options_.point, shares);
    bool whole = false;
    try {
      whole = compute_blocks(
          {own, trials_, options_.block_trials, options_.threads}, kernel_, [&] { return stopped(); },
          [&](std::uint64_t block, stats::Tally tally) {
            done_ += tally.trials * of_all;
            merge_.add(block, std::move(tally));
            if (options_.progress) options_.progress(std::min(done_, expected_), expected_);
            if (options_.save && options_.save_due && options_.save_due()) options_.save(merge_);
            if (options_.workers && options_.workers->poll()) other_stopped_ = true;
          });
    } catch (...) {
      drop_others();
      throw;
    }
    if (collect(whole) && whole) return;
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

  std::vector<std::vector<BlockRange>> divide(BlockRange range) const {
    return divided(gaps(range, covered_), 1 + (options_.workers ? options_.workers->count() : 0));
  }

  static std::uint64_t total(const std::vector<std::vector<BlockRange>>& shares) {
    std::uint64_t n = 0;
    for (const auto& s : shares) n += count_of(s);
    return n;
  }

  /// Waits for the other ranks, telling them to stop if our own share is not `whole`. True if their shares are whole.
  bool collect(bool whole) {
    if (!options_.workers) return true;
    if (!whole) options_.workers->stop();
    Workers::Work work = options_.workers->collect([&] { return stopped(); });
    for (Subtree& n : work.subtrees) merge_.add(std::move(n), false);
    return !work.cut_short;
  }

  /// Our own error is reported, and not those of other ranks that follow from telling them to stop.
  void drop_others() {
    try {
      collect(false);
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
