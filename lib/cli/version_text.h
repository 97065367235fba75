#pragma once
#include <string>

namespace surveymc::cli {

/// What this program was built from, and by which compiler.
struct Build {
  const char *version, *git_revision, *compiler;
};
/// One source alone reads the revision, so that a commit or an edit recompiles nothing else for it.
Build this_build();

/// kNumericsMark, and what decides the bits of its numbers: version, compiler, libraries that compute, and the probe of
/// this machine; and the form of its tallies, which journals and parts have. The probe runs once.
const std::string& numerics_text();

/// What `surveymc --version` prints: version and revision, then compiler, HDF5, MPI (as given), instruction set,
/// numerics.
std::string version_text(const std::string& mpi);

}  // namespace surveymc::cli
