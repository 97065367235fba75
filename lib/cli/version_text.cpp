#include "cli/version_text.h"

#include <fmt/format.h>

#include "base/numerics.h"
#include "simd/instruction_set.h"
#include "simd/numerics_probe.h"
#include "store/result_file.h"
#include "version.h"

namespace surveymc::cli {

Build this_build() { return {kVersion, kGitRevision, kCompiler}; }

std::string numerics_text() {
  return fmt::format("{}{}, {}, probe {}", kNumericsMark, kNumericsVersion, kLibraries, simd::numerics_probe());
}

std::string version_text(const std::string& mpi) {
  return fmt::format(
      "surveymc {} ({})\ncompiler:        {}\nHDF5:            {}\nMPI:             {}\ninstruction set: {}\n"
      "numerics:        {}",
      kVersion, kGitRevision, kCompiler, store::hdf5_version(), mpi, simd::name(simd::instruction_set()),
      numerics_text().substr(kNumericsMark.size()));
}

}  // namespace surveymc::cli
