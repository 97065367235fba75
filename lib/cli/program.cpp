/// The command line: list, keys, new, models, check, run, plan, merge, status, show, rerun, man, completion
/// (README.md). Prints;
/// all work is in lib/ and the studies.
#include <cerrno>
#include <cfenv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <optional>
#include <set>
#include <sstream>
#include <variant>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>
#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include "base/error.h"
#include "base/huge_pages.h"
#include "base/numerics.h"
#include "base/shell_word.h"
#include "cli/command_line.h"
#include "cli/command_words.h"
#include "cli/commands.h"
#include "cli/log.h"
#include "cli/print_result.h"
#include "cli/program.h"
#include "cli/progress.h"
#include "cli/rank_work.h"
#include "cli/run_setup.h"
#include "cli/screen.h"
#include "cli/version_text.h"
#include "montecarlo/workers.h"
#include "simd/numerics_probe.h"
#include "store/atomic_file.h"

namespace surveymc::cli {
namespace {

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

store::Result run_and_stamp(const RunArguments& a, const study::RunPlan& run, const std::string& command,
                            Effort& effort, const study::Checkpoint& checkpoint = {}) {
  for (const auto& [point, nodes] : checkpoint.finished)
    for (const montecarlo::Subtree& n : nodes) effort.kept += n.tally.trials;
  Progress progress(effort.kept, run.total_trials() > 0 ? "trials" : "stations");
  const auto created = std::chrono::system_clock::now();
  store::Result result = study::execute(run, run_options(a, run, progress, false), checkpoint, &effort.trials);
  effort.elapsed = progress.elapsed_s();
  stamp(result, command);
  result.run = run_info(created, effort.elapsed, a);
  return result;
}

/// Large results come in pieces, each made in memory that the piece before has just given back. By default glibc hands
/// such memory to the kernel at once, and gets it back as empty pages, which took more time than a large map itself.
void keep_freed_memory() {
#if defined(M_TRIM_THRESHOLD)
  constexpr int kMebibyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMebibyte);  // the most that glibc takes
  mallopt(M_TRIM_THRESHOLD, 128 * kMebibyte);
#endif
}

/// The heap's next 64 MiB are huge pages where there are any: a run whose tables take many megabytes spends as long
/// on the faults of small ones as on the tables. Small runs take no longer: they use one or two. Not where addresses
/// are limited (ulimit -v): then they are needed for the stacks of threads.
void prefer_huge_heap() {
#if defined(M_TOP_PAD)
  if (rlimit most{}; getrlimit(RLIMIT_AS, &most) != 0 || most.rlim_cur != RLIM_INFINITY) return;
  constexpr int kHeap = 64 << 20, kUsual = 128 << 10;
  mallopt(M_TOP_PAD, kHeap);
  const auto* const before = static_cast<const char*>(sbrk(0));
  void* volatile more = std::malloc(2 * kUsual);
  const auto* const after = static_cast<const char*>(sbrk(0));
  std::free(more);
  mallopt(M_TOP_PAD, kUsual);  // where memory is limited, it is not asked for more than it needs
  if (after > before) prefer_huge_pages(before, static_cast<std::size_t>(after - before));
#endif
}

/// Of a result that takes long to write: how far the run is.
void tell_large_result(const store::Result& result, double elapsed, const std::string& output) {
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

int check(const RunArguments& a) {
  const study::RunPlan run = load(a);
  if (run.sample.invalid > 0)
    throw InputError(
        fmt::format("{} ({} of {} points of the sweep that were tried are invalid: a run goes on without "
                    "such points, and lists them)",
                    run.sample.first_reason, run.sample.invalid, run.sample.points));
  fmt::print("{}\n", printable_toml(run.config.resolved_text()));
  for (const std::string& line : remark_lines(run.config)) {
    std::string comment = on_screen("# " + store::printable(line), STDOUT_FILENO, 4);
    for (std::size_t at = 0; (at = comment.find("\n ", at)) != std::string::npos;) comment[at + 1] = '#';
    fmt::print("{}\n", comment);
  }
  std::set<std::string> printed;
  for (std::size_t i = 0; i < (run.is_large() ? 1 : run.point_count()); ++i) {
    const std::string details = run.plan(i)->details();
    if (!printed.insert(details).second) continue;
    std::istringstream lines(details);
    for (std::string text; std::getline(lines, text);)
      print_lines(fmt::format("#{}{}\n", text.empty() ? "" : " ", text));
  }
  if (run.is_large())
    fmt::print(
        "# a sample of {} points was read: values of every key, and random points; a point that turns out to be "
        "invalid is listed in the result\n",
        run.config.sample_points().size());
  fmt::print("# {}, {} trials in all; config hash {}\n", counted(run.point_count(), "sweep point"), run.total_trials(),
             run.is_large() ? run.config.source_hash() : run.config.hash());
  return kDone;
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
std::optional<store::Result> finished_result(const std::filesystem::path& output, const study::RunPlan& plan) {
  try {
    store::Result r = store::read_result(output);
    if (r.provenance.config_hash == plan.config.hash() && numerics_of(r.provenance.compiler) == numerics_text())
      return r;
  } catch (const IoError&) {  // not there, or what check_output_path() refuses
  }
  return std::nullopt;
}

int run(const RunArguments& a, const std::string& command) {
  prefer_huge_heap();
  catch_signals();
  stop_after(a.max_seconds);
  std::optional<EndsBySignal> ends(std::in_place, nullptr, EndsBySignal::soon());
  const bool part = is_part(a);
  const study::RunPlan plan = part || a.trial ? open_config(a) : load(a);
  if (a.trial) {
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
  const std::optional<study::PartChoice> choice = part_choice(a, plan);
  if (choice) study::read_points(plan, *choice, stop_flag());
  if (choice) {
    ends.reset();
    return run_one_part(a, plan, *choice, command);
  }
  refuse_endless(a.config, plan);
  std::filesystem::path output = a.output;
  if (output.empty()) {
    output = std::filesystem::path("results") / (std::filesystem::path(a.config).stem().string() + ".h5");
    std::error_code error;
    std::filesystem::create_directories("results", error);
    if (error) throw IoError(fmt::format("results: cannot be made: {}; name a file with -o", error.message()));
  }
  if (a.resume)
    if (const std::optional<store::Result> there = finished_result(output, plan)) {
      print_tables(*there, output.string(), a.units == "ft");
      const int exit = report_verdicts(*there, a.check);
      print_warnings(*there, a.quiet);
      checkpoint::remove_journals(output, run_key(plan, false));
      store::remove_stale_temporaries(store::resolved(output));
      say(fmt::format("{} is done already", output.string()));
      return exit;
    }
  ends.reset();
  store::check_output_path(output);
  log_info(fmt::format("{}: {} of {}, {} trials in all", a.config, counted(plan.point_count(), "point"),
                       plan.experiment.name(), plan.total_trials()));
  if (plan.sample.invalid > 0)
    log_warning(
        fmt::format("{} of {} points that were tried cannot be run, and the result will list such points; the "
                    "first: {}",
                    plan.sample.invalid, plan.sample.points, plan.sample.first_reason));
  log_remarks(plan.config);
  Effort effort;
  store::Result result;
  std::vector<std::filesystem::path> kept;
  with_checkpoint(
      a, run_key(plan, false), output, command,
      [&](const study::Checkpoint& checkpoint) { result = run_and_stamp(a, plan, command, effort, checkpoint); },
      [&] {
        tell_large_result(result, effort.elapsed, output.string());
        kept = write_result_file(a, output, result);
      });
  ends.emplace(nullptr, EndsBySignal::soon(fmt::format("{} is written", output.string())));
  print_tables(result, output.string(), a.units == "ft");
  const int exit = report_verdicts(result, a.check);
  print_warnings(result, a.quiet);
  say(plan.total_trials() == 0 ? fmt::format("wrote {} (in {})", output.string(), format_duration(effort.elapsed))
                               : fmt::format("wrote {} ({})", output.string(), effort.words()));
  tell_backup(kept);
  return exit;
}

int rerun(const std::string& file, const std::string& folder, const RunArguments& a, const std::string& command) {
  catch_signals();
  const EndsBySignal ends;  // nothing is written
  const store::Result stored = store::read_result(file);
  const study::RunPlan plan = read_rerun(*a.studies, file, stored, folder);
  Effort effort;
  const store::Result again = run_and_stamp(a, plan, command, effort);
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

int guarded_main(int argc, char** argv, const std::vector<study::Experiment>& studies, montecarlo::Workers& workers,
                 const montecarlo::Messages* messages, const std::string& mpi) {
  std::variant<CommandLine, int> read = read_command_line(argc, argv, [&] { return version_text(mpi); });
  if (const int* exit = std::get_if<int>(&read)) return *exit;
  CommandLine& line = std::get<CommandLine>(read);

  std::string command = "surveymc";
  for (int i = 1; i < argc; ++i) command += fmt::format(" {}", shell_quoted(argv[i]));
  RunArguments& a = line.arguments;
  a.studies = &studies;
  if (messages) a.workers = &workers;
  if (messages && a.threads == 0) a.threads = messages->threads();
  if (a.quiet) {
    log_only_warnings();
    if (!std::freopen("/dev/null", "w", stdout)) throw IoError("/dev/null: cannot be opened");
  }
  switch (line.command) {
    case Command::list:
      return fmt::print("{}", list_text(studies)), kDone;
    case Command::keys:
      return print_keys(studies, line.keys), kDone;
    case Command::new_config:
      return new_config(studies, line.made), kDone;
    case Command::models:
      return fmt::print("{}", printable_toml(models_text(line.models))), kDone;
    case Command::check:
      return check(a);
    case Command::run:
      return run(a, command);
    case Command::plan:
      return plan_parts(a, line.parts_plan);
    case Command::merge:
      return merge_files(a, line.parts, line.inputs, line.to_part);
    case Command::status:
      return status_of(line.parts_plan.folder);
    case Command::show:
      return show(line.shown), kDone;
    case Command::diff:
      return diff_results(line.compared);
    case Command::refine:
      return refine_result(line.refined);
    case Command::rerun:
      return rerun(line.file, line.inputs.empty() ? "." : line.inputs, a, command);
    case Command::man:
      return fmt::print("{}", man_page(program_words(), this_build().version)), kDone;
    case Command::completion:
      return fmt::print("{}", bash_completion(program_words())), kDone;
  }
  return kInternal;
}

constexpr const char* kNoMemory = "error: not enough memory: give the run more, or ask for less\n";

/// guarded_main with every exception reported and turned into its exit code.
int told_main(int argc, char** argv, ListStudies studies, montecarlo::Workers& workers,
              const montecarlo::Messages* messages, const std::string& mpi) {
  const auto fails = [](int exit, const char* kind, const char* what) {  // fmt would throw: the log's disk may be full
    std::fprintf(stderr, "%s%s\n", kind, printable_lines(what).c_str());
    return exit;
  };
  try {
    const int exit = guarded_main(argc, argv, studies(), workers, messages, mpi);
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit;
    return fails(kCannotWrite, "error: standard output: ", "cannot be written");
  } catch (const UsageError& e) {
    return fails(kUsage, "error: ", e.what());
  } catch (const InputError& e) {
    return fails(kBadInput, "error: ", e.what());
  } catch (const IoError& e) {
    return fails(kCannotWrite, "error: ", e.what());
  } catch (const Resumable& e) {
    return fails(kInterrupted, "interrupted: ", e.what());
  } catch (const Interrupted&) {
    return fails(kInterrupted, "interrupted: ", "nothing was written");
  } catch (const montecarlo::NoThreads& e) {
    return fails(kNoThreads, "error: ", e.what());
  } catch (const std::bad_alloc&) {  // no memory for anything else either
    std::fputs(kNoMemory, stderr);
    return kInternal;
  } catch (const std::exception& e) {
    return std::ferror(stdout) != 0 ? fails(kCannotWrite, "error: standard output: ", e.what())
                                    : fails(kInternal, "internal error: ", e.what());
  }
}

}  // namespace

void fill_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(descriptor, F_GETFD) < 0 && errno == EBADF) {
      // Only to be read: what is printed to a closed output still is an error there.
      const int opened = open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);
      (void)opened;  // the lowest free number is this one
    }
}

namespace {

/// HDF5 calls exit(-1) where it gets no memory for some of its own records.
void tell_end_by_library() {
#if defined(__GLIBC__)
  static const pid_t program = getpid();  // children that read a file end as they are
  const auto tell = [](int status, void*) {
    if (status != -1 || getpid() != program) return;
    store::AtomicFile::remove_all();
    std::fputs(kNoMemory, stderr);
    _exit(kInternal);
  };
  const int refused = on_exit(tell, nullptr);
  (void)refused;  // then such an end has no message
#endif
}

}  // namespace

int program_main(int argc, char** argv, ListStudies studies, montecarlo::Messages* messages, const std::string& mpi) {
  keep_freed_memory();
  tell_end_by_library();
  fill_standard_descriptors();
  std::fesetenv(FE_DFL_ENV);  // a library may have changed it when it was loaded: bits must not depend on that
  simd::fix_block_sizes();
  if (const std::string fault = provide_stacks(); !fault.empty()) {
    std::fprintf(stderr, "error: %s\n", fault.c_str());
    return kNoThreads;
  }
  std::signal(SIGXFSZ, SIG_IGN);  // a file-size limit then is an error of write(), with a message, and does not kill us
  try {
    if (messages && messages->rank() > 0) return work_for_rank_0(studies(), *messages, argc, argv);
    montecarlo::Workers workers(messages);
    const int exit = told_main(argc, argv, studies, workers, messages, mpi);
    workers.end(exit);
    return exit;
  } catch (const std::exception& e) {  // between ranks: a rank that went on alone would wait for ever
    std::fprintf(stderr, "internal error: rank %d: %s\n", messages ? messages->rank() : 0, e.what());
    if (messages) messages->abort(kInternal);
    return kInternal;
  }
}

}  // namespace surveymc::cli
