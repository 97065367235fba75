#include "run_setup.h"

#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <csignal>
#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "log.h"
#include "montecarlo/workers.h"
#include "rank_work.h"
#include "stored_inputs.h"
#include "version.h"

namespace surveymc {
namespace {

std::atomic<bool> g_stop = false;  // set by a signal handler, read at block boundaries
extern "C" void on_signal(int) { g_stop = true; }

}  // namespace

void catch_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGALRM}) std::signal(signal, on_signal);
}

const std::atomic<bool>* stop_flag() { return &g_stop; }

void stop_after(double seconds) {
  if (seconds <= 0) return;
  constexpr double kLongest = 1e9;
  const double whole = std::min(seconds, kLongest);
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(whole);
  timer.it_value.tv_usec = static_cast<suseconds_t>((whole - static_cast<double>(timer.it_value.tv_sec)) * 1e6) + 1;
  if (timer.it_value.tv_usec > 999'999) timer.it_value.tv_usec = 999'999;
  setitimer(ITIMER_REAL, &timer, nullptr);
}

RunPlan read_rerun(const std::vector<Experiment>& studies, const std::string& file, const Result& stored,
                   const std::string& folder) {
  StoredInputs in = stored_inputs(stored);
  Config config = Config::from_text(stored.provenance.config, file, std::move(in.tables), std::move(in.texts),
                                    std::move(in.references), folder);
  const Experiment& experiment = find_experiment(studies, config);
  return read_run(experiment, std::move(config), &g_stop);
}

std::uint64_t whole_number(const std::string& option, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  require(error == std::errc() && end == text.data() + text.size() && !text.empty() && value < (1ull << 63),
          "{} {}: must be a whole number, 0 or more", option, text);
  return value;
}

const Experiment& find_experiment(const std::vector<Experiment>& studies, const Config& config) {
  std::string known;
  for (const Experiment& e : studies) {
    if (e.name() == config.experiment()) return e;
    known += (known.empty() ? "" : ", ") + e.name();
  }
  config.fail("experiment", "must be one of " + known);
}

RunPlan load(const RunArguments& a) {
  std::vector<std::string> overrides = a.set;
  if (a.seed) overrides.push_back(fmt::format("seed={}", whole_number("--seed", *a.seed)));
  if (a.trials) overrides.push_back(fmt::format("trials={}", whole_number("--trials", *a.trials)));
  Config config = Config::load(a.config, overrides);
  const Experiment& experiment = find_experiment(*a.studies, config);
  return read_run(experiment, std::move(config), &g_stop);
}

RunOptions run_options(const RunArguments& a, const RunPlan& run, Progress& progress) {
  RunOptions options;
  options.threads = a.threads;
  options.progress = [&](std::uint64_t done, std::uint64_t expected) { progress.update(done, expected); };
  options.stop = &g_stop;
  options.workers = a.workers;
  if (a.workers) a.workers->run = run_name(run);
  return options;
}

std::string program_name() { return fmt::format("surveymc {} ({}), {}", kVersion, kGitRevision, kCompiler); }

RunKey run_key(const RunPlan& run) { return {run.config.hash(), program_name()}; }

void stamp(Result& result, const std::string& command) {
  result.provenance.command = command;
  result.provenance.surveymc_version = kVersion;
  result.provenance.git_revision = kGitRevision;
  result.provenance.compiler = kCompiler;
}

RunInfo run_info(std::chrono::system_clock::time_point created, double elapsed, const RunArguments& a) {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  return {fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(created))), host,
          elapsed, a.threads > 0 ? a.threads : available_threads(),
          a.workers ? static_cast<int>(a.workers->count()) + 1 : 1};
}

Result with_checkpoint(const RunArguments& a, const RunPlan& run, const std::filesystem::path& output,
                       const std::string& command, const std::function<Result(const Checkpoint&)>& compute_and_write) {
  const RunKey key = run_key(run);
  JournalContents kept = read_journals(output, key);
  if (!a.resume && (!kept.finished.empty() || !kept.damaged.empty()))
    throw IoError(fmt::format(
        "{}: an earlier run of this config was not finished (or still runs): go on from it with --resume, or "
        "delete this journal to begin anew",
        journals_of(output).front().string()));
  for (const auto& path : kept.damaged)
    log_warning(fmt::format("{}: damaged at the end; what cannot be read is computed again", path.string()));
  std::uint64_t trials = 0;
  for (auto& [point, nodes] : kept.finished) {
    nodes = disjoint_subtrees(std::move(nodes));
    for (const Subtree& n : nodes) trials += n.tally.trials;
  }
  if (trials > 0) log_info(fmt::format("going on from {} trials that are done", trials));

  Journal journal(output, key, std::chrono::duration<double>(a.checkpoint_seconds));
  if (a.workers) a.workers->journal = output.string();
  try {
    Result result = compute_and_write({std::move(kept.finished), &journal});
    remove_journals(output, key);
    return result;
  } catch (const IoError& e) {  // all was computed, and the result cannot be written
    if (!journal.started() || !journal.sync()) throw;
    throw IoError(
        fmt::format("{}; what is done is kept beside it: when it can be written, go on with --resume", e.what()));
  } catch (const Interrupted&) {
    if (!journal.sync())
      throw IoError(fmt::format("interrupted, and the checkpoint beside {} could not be written: {}", output.string(),
                                journal.error()));
    if (journals_of(output).empty()) throw;
    throw Resumable(fmt::format("what is done is kept beside {}; go on with: {}{}", output.string(), command,
                                a.resume ? "" : " --resume"));
  }
}

}  // namespace surveymc
