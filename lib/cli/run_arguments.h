#pragma once
/// Arguments of the commands that compute or write a result, and what they ask of a run.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/progress.h"
#include "store/atomic_file.h"
#include "store/result_file.h"
#include "study/experiment.h"

namespace surveymc::cli {

struct RunArguments {
  std::string config, output;
  std::string units = "m";  // "ft": tables are printed in feet
  std::vector<std::string> set;
  int threads = 0;
  std::optional<std::string> trials, seed, trial, point, shard, shards;  // as typed, so that a message can show it
  bool check = false, array = false, resume = false, overwrite = false, quiet = false, verbose = false, json = false;
  int compression = 0;                                      // level of deflate; 0: none
  double max_seconds = 0, checkpoint_seconds = 5;           // 0: no limit
  montecarlo::Workers* workers = nullptr;                   // in surveymc-mpi
  const std::vector<study::Experiment>* studies = nullptr;  // that the program knows
};

/// What the arguments say of an older file of the output's name.
store::OldFile old_file(const RunArguments& a);

/// A whole number that an option was given.
std::uint64_t whole_number(const std::string& option, const std::string& text);

/// What --trials was given: 20000, 2e4, 20k or 2.5M.
std::uint64_t number_of_trials(const std::string& text);

/// Options of a run, with this stop flag. `part`: not all of its points are run.
montecarlo::RunOptions run_options(const RunArguments& a, const study::RunPlan& run, Progress& progress, bool part);

}  // namespace surveymc::cli
