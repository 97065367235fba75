#pragma once
/// Who made a result: this program, and the run; and the keys by which a run finds its own journals and parts.
#include <chrono>
#include <string>

#include "checkpoint/journal.h"
#include "cli/run_arguments.h"
#include "store/result_file.h"
#include "study/experiment.h"

namespace surveymc::cli {

/// This program: version, revision, compiler; behind them numerics_text().
const std::string& program_name();
/// Key of the journals of a run. `part`: of one that has read the points of a part only. Two attempts at the same run
/// have the same key when they have just read its points.
checkpoint::RunKey run_key(const study::RunPlan& run, bool part);
/// Key of the parts of a run, whichever points were read.
checkpoint::RunKey part_key(const study::RunPlan& run);
/// Writes this program and the command into the result.
void stamp(store::Result& result, const std::string& command);
store::RunInfo run_info(std::chrono::system_clock::time_point created, double elapsed, const RunArguments& a);

}  // namespace surveymc::cli
