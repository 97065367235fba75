#pragma once
/// The only MPI. Linked into surveymc-mpi; surveymc knows nothing of it.
#include <memory>

#include "montecarlo/messages.h"

namespace surveymc::mpi {

/// Starts MPI; ends it when it is destroyed. One at a time, once a process. Throws std::runtime_error.
std::unique_ptr<montecarlo::Messages> mpi_messages(int& argc, char**& argv);

/// Library and version, in one line.
std::string mpi_version();

}  // namespace surveymc::mpi
