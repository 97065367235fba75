#pragma once
/// From the arguments, or from a result that is repeated, to the run: its config, its study, its points.
#include <string>
#include <vector>

#include "cli/run_arguments.h"
#include "config/config.h"
#include "store/result_file.h"
#include "study/experiment.h"

namespace surveymc::cli {

const study::Experiment& find_experiment(const std::vector<study::Experiment>& studies, const config::Config& config);
/// The run that the arguments name, all of its points read (of a large sweep, a sample).
study::RunPlan load(const RunArguments& a);
/// The same without any point read.
study::RunPlan open_config(const RunArguments& a);

/// The run that made the result `stored`, read from `file`. `folder`: the folder of the config, which has the files
/// that were too large to be stored. `threads` read its points; 0: as many as there are.
study::RunPlan read_rerun(const std::vector<study::Experiment>& studies, const std::string& file,
                          const store::Result& stored, const std::string& folder, int threads = 0);

/// The input files that a result stores beside its config, in the form that the config reader takes.
config::StoredInputs stored_inputs(const store::Result& result);

/// What a run tells of the inputs that were read before it begins: notes and warnings, at most so many of each; of more
/// (a sweep over places) how many.
inline constexpr std::size_t kMostRemarks = 8;
std::vector<std::string> remark_lines(const config::Config& config);
/// Says them in the log.
void log_remarks(const config::Config& config);
/// The warnings alone.
void log_warnings(const config::Config& config);
/// The same of a run whose result will have the warnings: notes, and how many warnings there are.
void log_notes(const config::Config& config);

}  // namespace surveymc::cli
