#pragma once
/// The work of ranks other than 0 in surveymc-mpi.
#include "montecarlo/messages.h"
#include "montecarlo/workers.h"
#include "study/experiment.h"

namespace surveymc::cli {

/// A text that is equal for two ranks if they run the same config with the same program.
std::string run_name(const checkpoint::RunKey& key);

/// Computes blocks of the run that the command line names until rank 0 ends it; returns rank 0's exit code. Prints
/// nothing: rank 0 reports errors.
int work_for_rank_0(const std::vector<study::Experiment>& studies, montecarlo::Messages& messages, int argc,
                    char** argv);

}  // namespace surveymc::cli
