#include <cstdio>
#include <exception>

#include "cli/process_setup.h"
#include "cli/program.h"
#include "mpi/mpi_messages.h"
#include "registry.h"

int main(int argc, char** argv) {
  surveymc::cli::fill_standard_descriptors();
  try {
    const auto messages = surveymc::mpi::mpi_messages(argc, argv);
    return surveymc::cli::program_main(argc, argv, surveymc::studies::all_experiments, messages.get(),
                                       surveymc::mpi::mpi_version());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "internal error: %s\n", e.what());
    return 70;
  }
}
