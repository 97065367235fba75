#pragma once
/// Functions that the commands of the program share: arguments, loading, signals, checkpoints, provenance.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "cli/progress.h"
#include "config/config.h"
#include "store/atomic_file.h"
#include "store/result_file.h"
#include "study/experiment.h"

namespace surveymc::cli {

// sysexits.h, as documented in the README
enum Exit {
  kDone = 0,
  kUnexpected = 1,
  kUsage = 64,
  kBadInput = 65,
  kInternal = 70,
  kNoThreads = 71,
  kCannotWrite = 74,
  kInterrupted = 75
};

/// The command line is wrong, though each of its words may be right. what() says option, value, rule. Exit code 64.
class UsageError : public InputError {
 public:
  using InputError::InputError;
};

/// Throws UsageError unless `ok`.
template <class... Args>
void require_usage(bool ok, fmt::format_string<Args...> format, Args&&... args) {
  if (!ok) throw UsageError(fmt::format(format, std::forward<Args>(args)...));
}

/// The run was interrupted and its finished work was kept: what() says how to go on.
class Resumable : public Interrupted {
 public:
  using Interrupted::Interrupted;
};

struct RunArguments {
  std::string config, output;
  std::string units = "m";  // "ft": tables are printed in feet
  std::vector<std::string> set;
  int threads = 0;
  std::optional<std::string> trials, seed, trial, point, shard, shards;  // as typed, so that a message can show it
  bool check = false, array = false, resume = false, overwrite = false, quiet = false;
  int compression = 0;                                      // level of deflate; 0: none
  double max_seconds = 0, checkpoint_seconds = 5;           // 0: no limit
  montecarlo::Workers* workers = nullptr;                   // in surveymc-mpi
  const std::vector<study::Experiment>* studies = nullptr;  // that the program knows
};

/// What the arguments say of an older file of the output's name.
store::OldFile old_file(const RunArguments& a);
/// Writes the result as the arguments ask (store/result_file.h, store/large_files.h). Returns the new names of older
/// results.
std::vector<std::filesystem::path> write_result_file(const RunArguments& a, const std::filesystem::path& path,
                                                     const store::Result& result);

/// A whole number that an option was given.
std::uint64_t whole_number(const std::string& option, const std::string& text);

/// What a run tells of the inputs that were read before it begins: notes and warnings, at most so many of each; of more
/// (a sweep over places) how many.
inline constexpr std::size_t kMostRemarks = 8;
std::vector<std::string> remark_lines(const config::Config& config);
/// Says them in the log.
void log_remarks(const config::Config& config);

const study::Experiment& find_experiment(const std::vector<study::Experiment>& studies, const config::Config& config);
/// The run that the arguments name, all of its points read (of a large sweep, a sample).
study::RunPlan load(const RunArguments& a);
/// The same without any point read.
study::RunPlan open_config(const RunArguments& a);

/// The run that made the result `stored`, read from `file`. `folder`: the folder of the config, which has the files
/// that were too large to be stored.
study::RunPlan read_rerun(const std::vector<study::Experiment>& studies, const std::string& file,
                          const store::Result& stored, const std::string& folder);

/// From now on SIGINT, SIGTERM, SIGUSR1, SIGALRM, and SIGHUP and SIGXCPU unless they are ignored, set the stop flag and
/// do nothing else. Call this before any long computation, so that no signal ends the program in another way.
void catch_signals();
const std::atomic<bool>* stop_flag();

/// While it lives, a signal ends the program within a second (exit code 75) even if nobody looks at the stop flag:
/// after .8 s (or Says::after_ms), with the journal written and temporary files removed. Only one at a time. A rank
/// that ends so takes the others with it.
class EndsBySignal {
 public:
  struct Says {
    std::string kept = {};                        ///< where the journal has work
    std::string nothing = "nothing was written";  ///< where it has none
    int after_ms = 800;                           ///< time for an orderly end
  };
  /// Of work that leaves nothing behind: it is not waited for.
  static Says soon(std::string nothing = "nothing was written") {
    return {.nothing = std::move(nothing), .after_ms = 200};
  };
  explicit EndsBySignal(checkpoint::Journal* journal = nullptr) : EndsBySignal(journal, Says()) {}
  EndsBySignal(checkpoint::Journal* journal, Says says);
  ~EndsBySignal();
  EndsBySignal(const EndsBySignal&) = delete;
  EndsBySignal& operator=(const EndsBySignal&) = delete;
};

/// Sets the stop flag after `seconds`, if not 0. Call catch_signals() first.
void stop_after(double seconds);

/// Options of a run, with this stop flag. `part`: not all of its points are run.
montecarlo::RunOptions run_options(const RunArguments& a, const study::RunPlan& run, Progress& progress, bool part);

/// This program: version, revision, compiler; behind them numerics_text().
const std::string& program_name();
/// Key of the journals of a run. `part`: of one that has read the points of a part only. Two attempts at the same run
/// have the same key when they have just read its points.
checkpoint::RunKey run_key(const study::RunPlan& run, bool part);
/// Key of the parts of a run, whichever points were read.
checkpoint::RunKey part_key(const study::RunPlan& run);
void stamp(store::Result& result, const std::string& command);
store::RunInfo run_info(std::chrono::system_clock::time_point created, double elapsed, const RunArguments& a);

/// Prints where the files are now that stood in the place of a new one.
void tell_backup(const std::vector<std::filesystem::path>& kept);

/// Runs `compute` with the journals of `output`, then `write`, and removes the journals afterwards. Throws IoError if
/// there are journals and a.resume is not set, or journals of another config; Resumable if the run was interrupted and
/// work was kept.
void with_checkpoint(const RunArguments& a, const checkpoint::RunKey& key, const std::filesystem::path& output,
                     const std::string& command, const std::function<void(const study::Checkpoint&)>& compute,
                     const std::function<void()>& write);

/// The input files that a result stores beside its config, in the form that the config reader takes.
config::StoredInputs stored_inputs(const store::Result& result);

}  // namespace surveymc::cli
