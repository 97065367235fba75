#pragma once
/// What the commands of the program share: arguments, loading, signals, checkpoints, provenance.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "cli/progress.h"
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
  kCannotWrite = 74,
  kInterrupted = 75
};

/// Interrupted, and what is done was kept: what() says how to go on.
class Resumable : public Interrupted {
 public:
  using Interrupted::Interrupted;
};

struct RunArguments {
  std::string config, output;
  std::vector<std::string> set;
  int threads = 0;
  std::optional<std::string> trials, seed, trial, point, shard, shards;  // as typed, so that a message can show it
  bool check = false, array = false, resume = false;
  double max_seconds = 0, checkpoint_seconds = 5;           // 0: no limit
  montecarlo::Workers* workers = nullptr;                   // in surveymc-mpi
  const std::vector<study::Experiment>* studies = nullptr;  // that the program knows
};

/// A whole number that an option was given.
std::uint64_t whole_number(const std::string& option, const std::string& text);

const study::Experiment& find_experiment(const std::vector<study::Experiment>& studies, const config::Config& config);
study::RunPlan load(const RunArguments& a);

/// The run that `stored`, read from `file`, says it is of. `folder`: that of the config, where files are that were too
/// large to be stored.
study::RunPlan read_rerun(const std::vector<study::Experiment>& studies, const std::string& file,
                          const store::Result& stored, const std::string& folder);

/// From now on SIGINT, SIGTERM, SIGUSR1 and SIGALRM set the stop flag and do nothing else. Called before anything that
/// takes time, so that no signal finds the program without it.
void catch_signals();
const std::atomic<bool>* stop_flag();

/// Sets the stop flag then, if `seconds` is not 0; after catch_signals().
void stop_after(double seconds);

/// Options of a run whose stop flag is that one.
montecarlo::RunOptions run_options(const RunArguments& a, const study::RunPlan& run, Progress& progress);

/// This program: version, revision, compiler.
std::string program_name();
checkpoint::RunKey run_key(const study::RunPlan& run);
void stamp(store::Result& result, const std::string& command);
store::RunInfo run_info(std::chrono::system_clock::time_point created, double elapsed, const RunArguments& a);

/// Runs `compute_and_write` with the journals of `output`, which are gone when it returns. Throws IoError if there are
/// some and a.resume is not set, or of another config; Resumable if it was interrupted and something was kept.
store::Result with_checkpoint(const RunArguments& a, const study::RunPlan& run, const std::filesystem::path& output,
                              const std::string& command,
                              const std::function<store::Result(const study::Checkpoint&)>& compute_and_write);

}  // namespace surveymc::cli
