#include "cli/kept_work.h"

#include <chrono>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/error.h"
#include "cli/exit_codes.h"
#include "cli/log.h"
#include "cli/screen.h"
#include "montecarlo/workers.h"

namespace surveymc::cli {

KeptWork::KeptWork(const RunArguments& a, const checkpoint::RunKey& key, std::filesystem::path output,
                   const std::string& command)
    : key_(key),
      output_(std::move(output)),
      ends_(std::in_place),
      kept_(checkpoint::read_journals(output_, key)),
      go_on_(fmt::format("what is done is kept beside {}; go on with: {}{}", output_.string(), command,
                         a.resume ? "" : " --resume")) {
  if (!a.resume && (!kept_.finished.empty() || !kept_.points.empty() || !kept_.damaged.empty())) {
    const std::vector<std::filesystem::path> journals = checkpoint::journals_of(output_);
    throw IoError(fmt::format(
        "{}: an earlier run of this config was not finished (or still runs): go on from it with --resume, or "
        "delete this journal to begin anew",
        // one that still runs may have just finished
        journals.empty() ? output_.string() : journals.front().string()));
  }
  for (const auto& path : kept_.damaged)
    log_warning(fmt::format("{}: is damaged; what cannot be read is computed again", path.string()));
  const checkpoint::JournalRemarks remarks = checkpoint::journal_remarks(output_, key);
  for (const std::string& warning : remarks.warnings) log_warning(warning);
  for (const std::string& note : remarks.notes) log_info(note);
  for (auto& [point, nodes] : kept_.finished) {
    nodes = montecarlo::disjoint_subtrees(std::move(nodes));
    for (const montecarlo::Subtree& n : nodes) trials_ += n.tally.trials;
  }
  if (trials_ > 0) log_info(fmt::format("going on from {} trials that are done", trials_));
  if (!kept_.points.empty())
    log_info(fmt::format("going on from {} that {} done", counted(kept_.points.size(), "point"),
                         kept_.points.size() == 1 ? "is" : "are"));

  journal_.emplace(output_, key, std::chrono::duration<double>(a.checkpoint_seconds));
  if (a.workers) a.workers->journal = output_.string();
  ends_.reset();
  ends_.emplace(&*journal_, EndMessage{.kept = go_on_});
}

study::Checkpoint KeptWork::checkpoint() {
  return {std::move(kept_.finished), &*journal_, std::move(kept_.points), std::move(kept_.drawn_in)};
}

void KeptWork::rethrow() {
  try {
    throw;
  } catch (const IoError& e) {  // all was computed, but the result cannot be written
    if (!journal_->is_there() || !journal_->sync()) throw;
    throw IoError(
        fmt::format("{}; what is done is kept beside it: when it can be written, go on with --resume", e.what()));
  } catch (const Interrupted&) {
    ends_.reset();
    if (!journal_->sync())
      throw IoError(fmt::format("interrupted, and the checkpoint beside {} could not be written: {}", output_.string(),
                                journal_->error()));
    if (checkpoint::journals_of(output_).empty()) throw;
    throw Resumable(go_on_);
  }
}

void KeptWork::remove() {
  ends_.reset();
  checkpoint::remove_journals(output_, key_);
}

}  // namespace surveymc::cli
