#include "cli/version_text.h"

#include <fmt/format.h>

#include "simd/instruction_set.h"
#include "store/result_file.h"
#include "version.h"

namespace surveymc::cli {

Build this_build() { return {kVersion, kGitRevision, kCompiler}; }

std::string version_text(const std::string& mpi) {
  return fmt::format(
      "surveymc {} ({})\ncompiler:        {}\nHDF5:            {}\nMPI:             {}\ninstruction set: {}", kVersion,
      kGitRevision, kCompiler, store::hdf5_version(), mpi, simd::name(simd::instruction_set()));
}

}  // namespace surveymc::cli
