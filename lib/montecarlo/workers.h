#pragma once
/// Blocks computed by other ranks. Rank 0 runs the program; the others serve(): they wait for orders, compute blocks of
/// sweep points, and send back subtrees. A stop or an error of one rank stops all.
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "montecarlo/messages.h"
#include "montecarlo/run_blocks.h"

namespace surveymc::montecarlo {

/// Work that rank 0 orders from another rank.
struct BlockOrder {
  std::string run;      ///< config and program, which must be the same on both ranks
  std::string journal;  ///< output beside which the journal is kept; empty: none is kept
  std::uint64_t point = 0;
  std::vector<BlockRange> blocks = {};
};

/// The other ranks, as seen from rank 0. Without other ranks, all members do nothing.
class Workers {
 public:
  /// `messages`: of rank 0; none: there are no other ranks.
  explicit Workers(Messages* messages) : messages_(messages) {}

  std::size_t count() const { return messages_ ? static_cast<std::size_t>(messages_->count() - 1) : 0; }
  std::string run, journal;  ///< of all orders

  /// The number of blocks that gives each thread of a rank one block, if it has as many threads as this rank.
  std::uint64_t least_piece() const;
  /// Worker `worker` (0 to count() - 1) computes these blocks behind those that it has.
  void order(std::uint64_t point, std::size_t worker, const std::vector<BlockRange>& blocks);
  /// Receives all messages that have arrived; calls `is_free` with each worker that has done an order. True if a worker
  /// has stopped or failed: then all are told to stop.
  bool poll(const std::function<void(std::size_t)>& is_free);
  /// What poll() has received.
  std::vector<Subtree> taken() { return std::exchange(work_.subtrees, {}); }
  /// Tells all workers to stop for good: blocks ordered afterwards come back uncomputed.
  void stop();
  /// Waits for all ordered blocks, asking `stopped` meanwhile whether to tell all workers to stop; `is_free` as in
  /// poll(). Throws the error of a worker, as InputError, IoError or std::runtime_error.
  struct Work {
    std::vector<Subtree> subtrees;
    bool cut_short = false;
  };
  Work collect(const std::function<bool()>& stopped, const std::function<void(std::size_t)>& is_free);
  /// Ends all; their serve() returns `exit`.
  void end(int exit);

 private:
  void take(const Message& m);

  Messages* messages_;
  std::size_t open_ = 0;  // orders without an answer
  Work work_;
  std::string error_;  // the first one; its kind in front
  bool stopped_ = false;
};

/// How a worker computes the blocks of an order.
struct Share {
  std::uint64_t trials = 0;  ///< of the point
  BlockKernel kernel;
  RunOptions options;  ///< threads, stop, block size, journal
};

/// The loop of a rank other than 0: computes ordered blocks until rank 0 ends it, and returns the exit code that rank 0
/// gives. Rank 0 reports the exceptions of share_of and of kernels.
int serve(Messages& messages, const std::function<Share(const BlockOrder&)>& share_of);

}  // namespace surveymc::montecarlo
