#include <cstdio>
#include <exception>

#include "experiments.h"
#include "montecarlo/mpi_messages.h"
#include "program.h"

int main(int argc, char** argv) {
  try {
    const auto messages = surveymc::mpi_messages(argc, argv);
    return surveymc::program_main(argc, argv, surveymc::all_experiments(), messages.get(), surveymc::mpi_version());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "internal error: %s\n", e.what());
    return 70;
  }
}
