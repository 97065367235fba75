#pragma once
/// What ranks other than 0 do in surveymc-mpi.
#include "montecarlo/messages.h"
#include "montecarlo/workers.h"
#include "study/experiment.h"

namespace surveymc::cli {

/// Says that two ranks run the same thing: config, program.
std::string run_name(const study::RunPlan& run);

/// Computes blocks of what the command line says until rank 0 ends it; returns rank 0's exit code. Prints nothing:
/// errors are rank 0's to tell.
int work_for_rank_0(const std::vector<study::Experiment>& studies, montecarlo::Messages& messages, int argc,
                    char** argv);

}  // namespace surveymc::cli
