#include "cli/run_arguments.h"

#include <charconv>
#include <system_error>
#include <utility>
#include <variant>

#include "base/count.h"
#include "cli/exit_codes.h"
#include "cli/provenance.h"
#include "cli/rank_work.h"
#include "cli/signals.h"
#include "montecarlo/workers.h"

namespace surveymc::cli {
namespace {

SweepPace pace_of(const study::RunPlan& run) {
  std::vector<PacedPoint> points;
  for (std::size_t i = 0; i < run.point_count(); ++i) {
    PacedPoint p{run.plan(i)->trials(), {}};
    for (const config::SweepValue& v : run.config.sweep_values(i))
      p.values.push_back(std::holds_alternative<double>(v.value) ? config::format_number(std::get<double>(v.value))
                                                                 : std::get<std::string>(v.value));
    points.push_back(std::move(p));
  }
  return SweepPace(std::move(points));
}

}  // namespace

store::OldFile old_file(const RunArguments& a) { return a.overwrite ? store::OldFile::replaced : store::OldFile::kept; }

std::uint64_t whole_number(const std::string& option, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  require_usage(error == std::errc() && end == text.data() + text.size() && !text.empty() && value < (1ull << 63),
                "{} {}: must be a whole number, 0 or more", option, text);
  return value;
}

std::uint64_t number_of_trials(const std::string& text) {
  const std::optional<std::uint64_t> count = count_of(text);
  require_usage(count.has_value(), "--trials {}: must be a whole number, 0 or more, such as 20000, 2e4 or 20k", text);
  return *count;
}

montecarlo::RunOptions run_options(const RunArguments& a, const study::RunPlan& run, Progress& progress, bool part) {
  montecarlo::RunOptions options;
  options.threads = a.threads;
  if (!part && !run.is_large()) progress.know(pace_of(run));
  if (!a.quiet) options.progress = [&](std::uint64_t done, std::uint64_t expected) { progress.update(done, expected); };
  options.stop = stop_flag();
  options.workers = a.workers;
  if (a.workers) a.workers->run = run_name(run_key(run, part));
  return options;
}

}  // namespace surveymc::cli
