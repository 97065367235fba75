#pragma once
/// Blocks computed by other ranks. Rank 0 runs the program; the others serve(): they wait for orders, compute blocks of
/// sweep points, and send back subtrees. A stop or an error of one rank stops all.
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "montecarlo/messages.h"
#include "montecarlo/run_blocks.h"

namespace surveymc::montecarlo {

/// What rank 0 asks of another rank.
struct BlockOrder {
  std::string run;      ///< what both must agree on: config and program
  std::string journal;  ///< output beside which the journal is kept; empty: none is kept
  std::uint64_t point = 0;
  std::vector<BlockRange> blocks = {};
};

/// The other ranks, as rank 0 has them. Without any, all of it does nothing.
class Workers {
 public:
  /// `messages`: of rank 0; none: there are no other ranks.
  explicit Workers(Messages* messages) : messages_(messages) {}

  std::size_t count() const { return messages_ ? static_cast<std::size_t>(messages_->count() - 1) : 0; }
  std::string run, journal;  ///< of all orders

  /// Worker w computes shares[w].
  void order(std::uint64_t point, const std::vector<std::vector<BlockRange>>& shares);
  /// Takes in what has come. True if a worker has stopped or failed: then all are told to stop.
  bool poll();
  /// Tells all to stop, once and for all: what is ordered afterwards comes back undone.
  void stop();
  /// Waits for all that was ordered, asking `stopped` meanwhile whether to tell all to stop. Throws the error of a
  /// worker, as InputError, IoError or std::runtime_error.
  struct Work {
    std::vector<Subtree> subtrees;
    bool cut_short = false;
  };
  Work collect(const std::function<bool()>& stopped);
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

/// A rank that is not 0: computes what is ordered until rank 0 ends it; returns the exit code that it then says.
/// Exceptions of share_of and of kernels are rank 0's to tell.
int serve(Messages& messages, const std::function<Share(const BlockOrder&)>& share_of);

}  // namespace surveymc::montecarlo
