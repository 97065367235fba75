#include "cli/program.h"
#include "registry.h"

int main(int argc, char** argv) {
  return surveymc::cli::program_main(argc, argv, surveymc::studies::all_experiments, nullptr, "no MPI");
}
