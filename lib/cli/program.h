#pragma once
#include <string>
#include <vector>

#include "montecarlo/messages.h"
#include "study/experiment.h"

namespace surveymc::cli {

/// Makes the list of studies; called where its errors are reported.
using ListStudies = std::vector<study::Experiment> (*)();

/// The program: parses the command line, runs the command with `studies`, prints, returns the exit code. With
/// `messages` every rank calls this function: rank 0 runs the command, the others compute blocks for rank 0 and print
/// nothing. `mpi`: for --version.
int program_main(int argc, char** argv, ListStudies studies, montecarlo::Messages* messages, const std::string& mpi);

}  // namespace surveymc::cli
