#include "program.h"

int main(int argc, char** argv) { return surveymc::program_main(argc, argv, nullptr, "no MPI"); }
