/// surveymc run and surveymc rerun: the stages of docs/architecture.md.
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "base/error.h"
#include "base/numerics.h"
#include "cli/commands.h"
#include "cli/exit_codes.h"
#include "cli/kept_work.h"
#include "cli/load_run.h"
#include "cli/log.h"
#include "cli/print_result.h"
#include "cli/progress.h"
#include "cli/provenance.h"
#include "cli/screen.h"
#include "cli/signals.h"
#include "cli/version_text.h"
#include "cli/write_output.h"
#include "store/atomic_file.h"

namespace surveymc::cli {
namespace {

namespace fs = std::filesystem;

/// What a run took. With a stopping rule it ends before its largest number of trials.
struct Effort {
  double elapsed = 0;                  ///< s
  std::uint64_t trials = 0, kept = 0;  ///< in the result; of them, from an earlier attempt

  /// "24576 trials in 0.1 s, 2.5e+05 trials/s"
  std::string words() const {
    std::string out = fmt::format("{} trials", trials);
    if (kept > 0) out += fmt::format(", {} of them from an earlier attempt,", kept);
    out += fmt::format(" in {}", format_duration(elapsed));
    if (trials > kept) out += fmt::format(", {:.3g} trials/s", static_cast<double>(trials - kept) / elapsed);
    return out;
  }
};

/// Prepares, runs and reports every point, and assembles the result, which then says by whom it was made.
store::Result compute(const RunArguments& a, const study::RunPlan& plan, const std::string& command, Effort& effort,
                      const study::Checkpoint& checkpoint = {}) {
  Progress progress(effort.kept, plan.total_trials() > 0 ? "trials" : "stations");
  const auto created = std::chrono::system_clock::now();
  store::Result result =
      study::execute(plan, run_options(a, plan, progress, /*part=*/false), checkpoint, &effort.trials);
  effort.elapsed = progress.elapsed_s();
  stamp(result, command);
  result.run = run_info(created, effort.elapsed, a);
  return result;
}

/// Says in the log how far the run is, if the result takes long to write.
void log_large_result(const store::Result& result, double elapsed, const std::string& output) {
  constexpr std::size_t kLarge = 1'000'000;
  std::size_t rows = 0, held = 0, streamed = 0;
  for (const auto* tables : {&result.tables, &result.samples})
    for (const store::Table& t : *tables) rows += t.rows();
  for (const store::Map& m : result.maps) held += m.values.size();
  for (const store::MapStream& s : result.streams)
    for (const store::Map& m : s.maps) streamed += store::map_size(m);
  if (rows + held + streamed < kLarge) return;
  std::string what = rows > 0 ? fmt::format("{} rows", rows) : "";
  if (held + streamed > 0) what += fmt::format("{}{} map values", what.empty() ? "" : " and ", held + streamed);
  log_info(fmt::format("computed in {}; writing {} to {}{}", format_duration(elapsed), what, output,
                       streamed > 0 ? "; maps are computed meanwhile" : ""));
}

/// Refuses a run that no machine ends: the rows of its result alone would fill more than a disk. Parts of such a sweep
/// can be run.
void refuse_endless(const std::string& config, const study::RunPlan& plan) {
  constexpr double kLargest = 1e12, kNumber = 8, kOwnColumns = 6;  // bytes; at least so many beside those of the sweep
  const double points = static_cast<double>(plan.point_count());
  const double row = kNumber * (kOwnColumns + static_cast<double>(plan.config.sweep_values(0).size()));
  require(
      points * row <= kLargest,
      "{}: sweep: {} points in one run: the result would have at least {:.3g} TB ({:.0f} bytes a point); at most 1 TB: "
      "sweep fewer values, or run parts of it with --point FIRST:END",
      config, plan.point_count(), points * row / 1e12, row);
}

/// The result that this run has made before; none if there is none, or one of another config or other numerics.
std::optional<store::Result> finished_result(const fs::path& output, const study::RunPlan& plan) {
  try {
    store::Result r = store::read_result(output);
    if (r.provenance.config_hash == plan.config.hash() && numerics_of(r.provenance.compiler) == numerics_text())
      return r;
  } catch (const IoError&) {  // not there, or what check_output_path() refuses
  }
  return std::nullopt;
}

/// The name of the result: by default in the folder results, which is made.
fs::path output_of(const RunArguments& a) {
  if (!a.output.empty()) return a.output;
  std::error_code error;
  fs::create_directories("results", error);
  if (error) throw IoError(fmt::format("results: cannot be made: {}; name a file with -o", error.message()));
  return fs::path("results") / (fs::path(a.config).stem().string() + ".h5");
}

/// Computes one trial again and prints it.
int replay_trial(const RunArguments& a) {
  const EndsBySignal ends(nullptr, EndMessage::at_once());
  const study::RunPlan plan = open_config(a);
  const std::uint64_t number = whole_number("--trial", *a.trial),
                      index = whole_number("--point", a.point.value_or("0"));
  require_usage(index < plan.point_count(), "--point {}: the points of this config are numbered 0 to {}", index,
                plan.point_count() - 1);
  const std::uint64_t trials = plan.plan(index)->trials();
  require_usage(trials > 0, "--trial {}: a config of {} has no trials", number, plan.experiment.name());
  require_usage(number < trials, "--trial {}: the trials of this config are numbered 0 to {}", number, trials - 1);
  montecarlo::RunOptions options;
  options.stop = stop_flag();
  fmt::print("{}", plan.prepare(index, options)->replay(number));
  return kDone;
}

void log_plan(const RunArguments& a, const study::RunPlan& plan) {
  log_info(fmt::format("{}: {} of {}, {} trials in all", a.config, counted(plan.point_count(), "point"),
                       plan.experiment.name(), plan.total_trials()));
  if (plan.sample.invalid > 0)
    log_warning(
        fmt::format("{} of {} points that were tried cannot be run, and the result will list such points; the "
                    "first: {}",
                    plan.sample.invalid, plan.sample.points, plan.sample.first_reason));
  log_notes(plan.config);
}

}  // namespace

int run_config(const RunArguments& a, const std::string& command) {
  catch_signals();
  stop_after(a.max_seconds);
  if (a.trial) return replay_trial(a);
  if (is_part(a)) return run_one_part(a, command);

  // read
  std::optional<EndsBySignal> ends(std::in_place, nullptr, EndMessage::at_once());
  const study::RunPlan plan = load(a);
  require_usage(!a.shards, "--shards: belongs to --array; without Slurm it is --shard I/N");
  refuse_endless(a.config, plan);
  const fs::path output = output_of(a);
  if (a.resume)
    if (const std::optional<store::Result> there = finished_result(output, plan)) {
      const int exit = print_findings(a, *there, output.string());
      checkpoint::remove_journals(output, run_key(plan, false));
      store::remove_stale_temporaries(store::resolved(output));
      if (!a.json) say(fmt::format("{} is done already", output.string()));
      return exit;
    }
  ends.reset();
  store::check_output_path(output);
  log_plan(a, plan);

  // prepare, run, report, assemble; write
  store::Result result;
  std::vector<fs::path> renamed;  // older results
  KeptWork kept(a, run_key(plan, false), output, command);
  Effort effort{.kept = kept.trials()};
  try {
    result = compute(a, plan, command, effort, kept.checkpoint());
    log_large_result(result, effort.elapsed, output.string());
    renamed = write_result_file(a, output, result);
  } catch (...) {
    log_warnings(plan.config);  // no result has them
    kept.rethrow();
  }
  kept.remove();

  ends.emplace(nullptr, EndMessage::at_once(fmt::format("{} is written", output.string())));
  const int exit = print_findings(a, result, output.string());
  if (a.json) return exit;
  say(plan.total_trials() == 0 ? fmt::format("wrote {} (in {})", output.string(), format_duration(effort.elapsed))
                               : fmt::format("wrote {} ({})", output.string(), effort.words()));
  print_backup(renamed);
  return exit;
}

int rerun_result(const std::string& file, const std::string& folder, const RunArguments& a,
                 const std::string& command) {
  catch_signals();
  const EndsBySignal ends;  // nothing is written
  const store::Result stored = store::read_result(file);
  const study::RunPlan plan = read_rerun(*a.studies, file, stored, folder, a.threads);
  Effort effort;
  const store::Result again = compute(a, plan, command, effort);
  const std::string before = store::stored_content_hash(file), now = store::content_hash(again);
  if (before == now) {
    fmt::print("identical: {} ({} trials in {})\n", now, effort.trials, format_duration(effort.elapsed));
    return kDone;
  }
  say(fmt::format("not identical: the file has {}, this run {}", before, now));
  if (stored.provenance.git_revision != this_build().git_revision)
    say(fmt::format("the file was made by surveymc {} ({}), this is {} ({})", stored.provenance.surveymc_version,
                    stored.provenance.git_revision, this_build().version, this_build().git_revision));
  if (const auto numerics = numerics_of(stored.provenance.compiler); numerics != numerics_text())
    say(fmt::format("their numbers may differ in the last bits: the file has {}, this program {}", numerics,
                    numerics_text()));
  if (store::content_hash(stored) != before)
    fmt::print("the file's data do not match its own content_hash: it was changed\n");
  return kUnexpected;
}

}  // namespace surveymc::cli
