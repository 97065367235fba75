#pragma once
#include <string>

namespace surveymc::cli {

/// What `surveymc --version` prints: version and revision, then compiler, HDF5, MPI (as given), instruction set.
std::string version_text(const std::string& mpi);

}  // namespace surveymc::cli
