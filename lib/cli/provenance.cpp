#include "cli/provenance.h"

#include <unistd.h>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "cli/version_text.h"
#include "montecarlo/threads.h"
#include "montecarlo/workers.h"

namespace surveymc::cli {

const std::string& program_name() {
  static const std::string name = [] {
    const Build build = this_build();
    return fmt::format("surveymc {} ({}), {}{}", build.version, build.git_revision, build.compiler, numerics_text());
  }();
  return name;
}

checkpoint::RunKey run_key(const study::RunPlan& run, bool part) {
  return {part || run.is_large() ? run.config.hash_as_read() : run.config.hash(), program_name()};
}

checkpoint::RunKey part_key(const study::RunPlan& run) { return {run.config.source_hash(), program_name()}; }

void stamp(store::Result& result, const std::string& command) {
  result.provenance.command = command;
  result.provenance.surveymc_version = this_build().version;
  result.provenance.git_revision = this_build().git_revision;
  result.provenance.compiler = this_build().compiler + numerics_text();
}

store::RunInfo run_info(std::chrono::system_clock::time_point created, double elapsed, const RunArguments& a) {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  return {fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(created))), host,
          elapsed, a.threads > 0 ? a.threads : montecarlo::available_threads(),
          a.workers ? static_cast<int>(a.workers->count()) + 1 : 1};
}

}  // namespace surveymc::cli
