#pragma once
/// Finished work of a run in journals beside its output, so that an interrupted run can go on.
#include <filesystem>
#include <optional>
#include <string>

#include "checkpoint/journal.h"
#include "cli/run_arguments.h"
#include "cli/signals.h"
#include "study/experiment.h"

namespace surveymc::cli {

/// What earlier attempts at this run have kept, and the journal of this one. While it lives, a signal ends the program
/// with the journal written. A run is
///   KeptWork kept(...);
///   try { compute with kept.checkpoint(); write; } catch (...) { kept.rethrow(); }
///   kept.remove();
class KeptWork {
 public:
  /// Reads the journals of `output` and says in the log what they hold. Throws IoError if there are some and a.resume
  /// is not set, or if they are of another config.
  KeptWork(const RunArguments& a, const checkpoint::RunKey& key, std::filesystem::path output,
           const std::string& command);

  /// What is computed already, and where to keep more. Call it once.
  study::Checkpoint checkpoint();
  /// Trials that earlier attempts have computed.
  std::uint64_t trials() const { return trials_; }

  /// In a handler: throws the exception again, as one that says how to go on if work was kept: Resumable for
  /// Interrupted.
  [[noreturn]] void rethrow();
  /// The output is written: removes the journals.
  void remove();

 private:
  checkpoint::RunKey key_;
  std::filesystem::path output_;
  std::optional<EndsBySignal> ends_;
  checkpoint::JournalContents kept_;
  std::uint64_t trials_ = 0;
  std::optional<checkpoint::Journal> journal_;
  std::string go_on_;  // how to go on
};

}  // namespace surveymc::cli
