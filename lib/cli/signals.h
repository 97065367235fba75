#pragma once
/// Signals and the time limit: they stop a run at the next block, or end the program within a second.
#include <atomic>
#include <string>
#include <utility>

#include "checkpoint/journal.h"

namespace surveymc::cli {

/// From now on SIGINT, SIGTERM, SIGUSR1, SIGALRM, and SIGHUP and SIGXCPU unless they are ignored, set the stop flag and
/// do nothing else. Call this before any long computation, so that no signal ends the program in another way.
void catch_signals();
const std::atomic<bool>* stop_flag();

/// What a signal prints when it ends the program, and how long it waits for an orderly end.
struct EndMessage {
  std::string kept = {};                        ///< printed where the journal has work
  std::string nothing = "nothing was written";  ///< printed where it has none
  int after_ms = 800;

  /// For work that leaves nothing behind: the program ends almost at once.
  static EndMessage at_once(std::string nothing = "nothing was written") {
    return {.nothing = std::move(nothing), .after_ms = 200};
  }
};

/// While it lives, a signal ends the program within a second (exit code 75) even if nobody looks at the stop flag:
/// after EndMessage::after_ms, with the journal written and temporary files removed. Only one at a time. A rank that
/// ends so takes the others with it.
class EndsBySignal {
 public:
  explicit EndsBySignal(checkpoint::Journal* journal = nullptr, EndMessage message = {});
  ~EndsBySignal();
  EndsBySignal(const EndsBySignal&) = delete;
  EndsBySignal& operator=(const EndsBySignal&) = delete;
};

/// Sets the stop flag after `seconds`, if not 0. Call catch_signals() first.
void stop_after(double seconds);

}  // namespace surveymc::cli
