#include "experiments.h"
#include "program.h"

int main(int argc, char** argv) {
  return surveymc::program_main(argc, argv, surveymc::all_experiments(), nullptr, "no MPI");
}
