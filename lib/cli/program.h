#pragma once
#include <string>
#include <vector>

#include "montecarlo/messages.h"
#include "study/experiment.h"

namespace surveymc::cli {

/// The program: parses the command line, does what it says with `studies`, prints, returns the exit code. With
/// `messages` every rank calls this: rank 0 does it, and the others compute for it and are silent. `mpi`: for
/// --version.
int program_main(int argc, char** argv, const std::vector<study::Experiment>& studies, montecarlo::Messages* messages,
                 const std::string& mpi);

}  // namespace surveymc::cli
