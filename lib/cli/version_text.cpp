#include "cli/version_text.h"

#include <cstdint>
#include <vector>

#include <fmt/format.h>

#include "base/numerics.h"
#include "earth/geographic_probe.h"
#include "estimate/nlopt_probe.h"
#include "montecarlo/ordered_merge.h"
#include "simd/instruction_set.h"
#include "simd/numerics_probe.h"
#include "store/result_file.h"
#include "version.h"

namespace surveymc::cli {

Build this_build() { return {kVersion, kGitRevision, kCompiler}; }

namespace {

/// Tells apart the forms in which builds write tallies: a member more makes an empty one longer.
std::uint32_t tally_form() {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  for (const char c : montecarlo::subtree_to_bytes({})) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return static_cast<std::uint32_t>(hash ^ (hash >> 32));
}

std::vector<double> library_values() {
  std::vector<double> values = earth::geographic_probe();
  const std::vector<double> more = estimate::nlopt_probe();
  values.insert(values.end(), more.begin(), more.end());
  return values;
}

}  // namespace

const std::string& numerics_text() {
  static const std::string text = fmt::format("{}{}, {}, probe {}, tallies {:08x}", kNumericsMark, kNumericsVersion,
                                              kLibraries, simd::numerics_probe(library_values()), tally_form());
  return text;
}

std::string version_text(const std::string& mpi) {
  return fmt::format(
      "surveymc {} ({})\ncompiler:        {}\nHDF5:            {}\nMPI:             {}\ninstruction set: {}\n"
      "numerics:        {}",
      kVersion, kGitRevision, kCompiler, store::hdf5_version(), mpi, simd::name(simd::instruction_set()),
      numerics_text().substr(kNumericsMark.size()));
}

}  // namespace surveymc::cli
