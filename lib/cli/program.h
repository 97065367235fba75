#pragma once
#include <string>
#include <vector>

#include "montecarlo/messages.h"
#include "study/experiment.h"

namespace surveymc::cli {

/// Makes the list of studies; called where its errors are told.
using ListStudies = std::vector<study::Experiment> (*)();

/// Opens /dev/null in the place of standard input, output and error where they are closed: no file that the program
/// writes gets their number, so that no message goes into it. Call this before anything opens a file; program_main()
/// does.
void fill_standard_descriptors();

/// The program: parses the command line, runs the command with `studies`, prints, returns the exit code. With
/// `messages` every rank calls this function: rank 0 runs the command, the others compute blocks for rank 0 and print
/// nothing. `mpi`: for --version.
int program_main(int argc, char** argv, ListStudies studies, montecarlo::Messages* messages, const std::string& mpi);

/// Sees to it that the main thread and all that are started later have stacks of 1 MiB at least: raises the limit of
/// the process (`ulimit -s`) and the size of new threads where they are smaller. What is wrong and the way out, if the
/// system does not allow that; "" if all is well. Call it before threads are started.
std::string provide_stacks();

}  // namespace surveymc::cli
