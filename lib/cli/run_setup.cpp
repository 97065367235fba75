#include "cli/run_setup.h"

#include <pthread.h>
#include <semaphore.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <csignal>
#include <ctime>
#include <mutex>
#include <system_error>
#include <thread>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "base/numerics.h"
#include "checkpoint/journal.h"
#include "cli/log.h"
#include "cli/print_result.h"
#include "cli/rank_work.h"
#include "cli/screen.h"
#include "cli/version_text.h"
#include "montecarlo/workers.h"
#include "store/atomic_file.h"
#include "store/large_files.h"

namespace surveymc::cli {
namespace {

std::atomic<bool> g_stop = false;  // set by a signal handler, read at block boundaries
sem_t g_signalled;                 // posted by it, for the thread that waits
extern "C" void on_signal(int) {
  g_stop = true;
  sem_post(&g_signalled);
}

/// What a signal may end: see EndsBySignal.
struct MayEnd {
  std::mutex changing;
  bool now = false;
  checkpoint::Journal* journal = nullptr;
  EndsBySignal::Says says;
};
MayEnd& may_end() {
  static MayEnd& one = *new MayEnd;  // the waiting thread outlives main()
  return one;
}

/// Ends the program, if it may be ended so long after the signal.
void end_program(std::chrono::milliseconds waited) {
  MayEnd& m = may_end();
  const std::scoped_lock lock(m.changing);
  if (!m.now || waited.count() < m.says.after_ms) return;
  const bool kept = m.journal && m.journal->sync() && m.journal->is_there();
  const std::string text = fmt::format("{}interrupted: {}\n", isatty(STDERR_FILENO) ? "\r\033[K" : "",
                                       printable_lines(kept ? m.says.kept : m.says.nothing));
  store::AtomicFile::remove_all();
  [[maybe_unused]] const ssize_t n = write(STDERR_FILENO, text.data(), text.size());
  _exit(kInterrupted);
}

void wait_for_signal() {
  constexpr auto kAgain = std::chrono::milliseconds(20);
  while (sem_wait(&g_signalled) != 0) {
  }
  const auto signalled = std::chrono::steady_clock::now();
  for (;; std::this_thread::sleep_for(kAgain))
    end_program(std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - signalled));
}

}  // namespace

void catch_signals() {
  sem_init(&g_signalled, 0, 0);
  sigset_t all, before;  // the waiting thread gets no signals
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  try {
    std::thread(wait_for_signal).detach();
  } catch (const std::system_error&) {  // no more threads: then the stop flag has to do
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGALRM}) std::signal(signal, on_signal);
  for (const int signal : {SIGHUP, SIGXCPU})  // the terminal is gone; a limit of processor time is near
    if (std::signal(signal, on_signal) == SIG_IGN) std::signal(signal, SIG_IGN);  // nohup
}

EndsBySignal::EndsBySignal(checkpoint::Journal* journal, Says says) {
  MayEnd& m = may_end();
  const std::scoped_lock lock(m.changing);
  m.journal = journal;
  m.says = std::move(says);
  m.now = true;
}

EndsBySignal::~EndsBySignal() {
  const std::scoped_lock lock(may_end().changing);
  may_end().now = false;
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

study::RunPlan read_rerun(const std::vector<study::Experiment>& studies, const std::string& file,
                          const store::Result& stored, const std::string& folder) {
  config::StoredInputs in;
  try {
    in = stored_inputs(stored);
  } catch (const IoError& e) {
    throw IoError(fmt::format("{}: {}", file, e.what()));
  }
  config::Config config = config::Config::from_text(stored.provenance.config, file, std::move(in.tables),
                                                    std::move(in.texts), std::move(in.references), folder);
  const study::Experiment& experiment = find_experiment(studies, config);
  return study::read_run(experiment, std::move(config), &g_stop);
}

store::OldFile old_file(const RunArguments& a) { return a.overwrite ? store::OldFile::replaced : store::OldFile::kept; }

std::vector<std::filesystem::path> write_result_file(const RunArguments& a, const std::filesystem::path& path,
                                                     const store::Result& result) {
  Progress progress(0, "MB");
  store::WriteOptions options{a.compression, {}, old_file(a)};
  if (!a.quiet)
    options.progress = [&](std::uint64_t written, std::uint64_t expected) {
      constexpr std::uint64_t kMegabyte = 1'000'000;
      progress.update(written / kMegabyte, expected / kMegabyte);
    };
  return store::write_result(path, result, options);
}

std::uint64_t whole_number(const std::string& option, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  require_usage(error == std::errc() && end == text.data() + text.size() && !text.empty() && value < (1ull << 63),
                "{} {}: must be a whole number, 0 or more", option, text);
  return value;
}

std::vector<std::string> remark_lines(const config::Config& config) {
  std::vector<std::string> lines;
  for (const bool warnings : {false, true}) {
    std::size_t count = 0;
    for (const config::Remark& r : config.remarks())
      if (r.is_warning == warnings && ++count <= kMostRemarks) lines.push_back((warnings ? "warning: " : "") + r.text);
    if (count > kMostRemarks)
      lines.push_back(fmt::format("{}and {} more of this kind", warnings ? "warning: " : "", count - kMostRemarks));
  }
  return lines;
}

void log_remarks(const config::Config& config) {
  for (const std::string& line : remark_lines(config))
    line.starts_with("warning: ") ? log_warning(line) : log_info(line);
}

const study::Experiment& find_experiment(const std::vector<study::Experiment>& studies, const config::Config& config) {
  std::string known;
  for (const study::Experiment& e : studies) {
    if (e.name() == config.experiment()) return e;
    known += (known.empty() ? "" : ", ") + e.name();
  }
  config.fail("experiment", "must be one of " + known);
}

namespace {

config::Config config_with_changes(const RunArguments& a) {
  std::vector<std::string> overrides = a.set;
  for (const std::string& s : overrides)
    require_usage(s.find('=') != std::string::npos && s.find('=') > 0, "--set {}: {}must be KEY=VALUE", s,
                  s.starts_with('=') ? "the key is missing: " : "");
  if (a.seed) overrides.push_back(fmt::format("seed={}", whole_number("--seed", *a.seed)));
  if (a.trials) overrides.push_back(fmt::format("trials={}", whole_number("--trials", *a.trials)));
  return config::Config::load(a.config, overrides);
}

}  // namespace

study::RunPlan load(const RunArguments& a) {
  config::Config config = config_with_changes(a);
  const study::Experiment& experiment = find_experiment(*a.studies, config);
  return study::read_run(experiment, std::move(config), &g_stop);
}

study::RunPlan open_config(const RunArguments& a) {
  config::Config config = config_with_changes(a);
  const study::Experiment& experiment = find_experiment(*a.studies, config);
  return study::open_run(experiment, std::move(config));
}

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

montecarlo::RunOptions run_options(const RunArguments& a, const study::RunPlan& run, Progress& progress, bool part) {
  montecarlo::RunOptions options;
  options.threads = a.threads;
  if (!part && !run.is_large()) progress.know(pace_of(run));
  if (!a.quiet) options.progress = [&](std::uint64_t done, std::uint64_t expected) { progress.update(done, expected); };
  options.stop = &g_stop;
  options.workers = a.workers;
  if (a.workers) a.workers->run = run_name(run_key(run, part));
  return options;
}

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

void tell_backup(const std::vector<std::filesystem::path>& kept) {
  for (const std::filesystem::path& name : kept) say(fmt::format("the file that was there is now {}", name.string()));
}

void with_checkpoint(const RunArguments& a, const checkpoint::RunKey& key, const std::filesystem::path& output,
                     const std::string& command, const std::function<void(const study::Checkpoint&)>& compute,
                     const std::function<void()>& write) {
  std::optional<EndsBySignal> reading(std::in_place);
  checkpoint::JournalContents kept = checkpoint::read_journals(output, key);
  if (!a.resume && (!kept.finished.empty() || !kept.points.empty() || !kept.damaged.empty())) {
    const std::vector<std::filesystem::path> journals = checkpoint::journals_of(output);
    throw IoError(fmt::format(
        "{}: an earlier run of this config was not finished (or still runs): go on from it with --resume, or "
        "delete this journal to begin anew",
        journals.empty() ? output.string() : journals.front().string()));  // one that still runs may have just finished
  }
  for (const auto& path : kept.damaged)
    log_warning(fmt::format("{}: is damaged; what cannot be read is computed again", path.string()));
  const checkpoint::JournalRemarks remarks = checkpoint::journal_remarks(output, key);
  for (const std::string& warning : remarks.warnings) log_warning(warning);
  for (const std::string& note : remarks.notes) log_info(note);
  std::uint64_t trials = 0;
  for (auto& [point, nodes] : kept.finished) {
    nodes = montecarlo::disjoint_subtrees(std::move(nodes));
    for (const montecarlo::Subtree& n : nodes) trials += n.tally.trials;
  }
  if (trials > 0) log_info(fmt::format("going on from {} trials that are done", trials));
  if (!kept.points.empty())
    log_info(fmt::format("going on from {} that {} done", counted(kept.points.size(), "point"),
                         kept.points.size() == 1 ? "is" : "are"));

  checkpoint::Journal journal(output, key, std::chrono::duration<double>(a.checkpoint_seconds));
  if (a.workers) a.workers->journal = output.string();
  const std::string go_on = fmt::format("what is done is kept beside {}; go on with: {}{}", output.string(), command,
                                        a.resume ? "" : " --resume");
  reading.reset();
  std::optional<EndsBySignal> computing(std::in_place, &journal, EndsBySignal::Says{.kept = go_on});
  try {
    compute({std::move(kept.finished), &journal, std::move(kept.points), std::move(kept.drawn_in)});
    write();
    computing.reset();
    checkpoint::remove_journals(output, key);
  } catch (const IoError& e) {  // all was computed, but the result cannot be written
    if (!journal.is_there() || !journal.sync()) throw;
    throw IoError(
        fmt::format("{}; what is done is kept beside it: when it can be written, go on with --resume", e.what()));
  } catch (const Interrupted&) {
    computing.reset();
    if (!journal.sync())
      throw IoError(fmt::format("interrupted, and the checkpoint beside {} could not be written: {}", output.string(),
                                journal.error()));
    if (checkpoint::journals_of(output).empty()) throw;
    throw Resumable(go_on);
  }
}

}  // namespace surveymc::cli
