/// The command line: list, check, run, show, rerun (README.md). Prints; all work is in lib/ and the studies.
#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <optional>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include "base/error.h"
#include "experiments.h"
#include "progress.h"
#include "simd/instruction_set.h"
#include "study/comparison.h"
#include "version.h"

namespace {

using namespace surveymc;

// sysexits.h, as documented in the README
enum Exit {
  kDone = 0,
  kUnexpected = 1,
  kUsage = 64,
  kBadInput = 65,
  kInternal = 70,
  kCannotWrite = 74,
  kInterrupted = 75
};

std::atomic<bool> g_stop = false;  // set by a signal handler, read at block boundaries
extern "C" void on_signal(int) { g_stop = true; }

struct RunArguments {
  std::string config, output;
  std::vector<std::string> set;
  int threads = 0;
  std::optional<std::string> trials, seed, trial, point;  // as typed, so that a message can show it
  bool check = false;
};

/// A whole number that an option was given.
std::uint64_t whole_number(const std::string& option, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  require(error == std::errc() && end == text.data() + text.size() && !text.empty() && value < (1ull << 63),
          "{} {}: must be a whole number, 0 or more", option, text);
  return value;
}

const Experiment& find_experiment(const std::vector<Experiment>& all, const Config& config) {
  std::string known;
  for (const Experiment& e : all) {
    if (e.name == config.experiment()) return e;
    known += (known.empty() ? "" : ", ") + e.name;
  }
  config.fail("experiment", "must be one of " + known);
}

PreparedRun load(const RunArguments& a) {
  std::vector<std::string> overrides = a.set;
  if (a.seed) overrides.push_back(fmt::format("seed={}", whole_number("--seed", *a.seed)));
  if (a.trials) overrides.push_back(fmt::format("trials={}", whole_number("--trials", *a.trials)));
  Config config = Config::load(a.config, overrides);
  const std::vector<Experiment> all = all_experiments();
  const Experiment& experiment = find_experiment(all, config);
  return prepare_run(experiment, std::move(config));
}

RunOptions run_options(int threads, Progress& progress) {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  return {threads, [&](std::uint64_t done, std::uint64_t expected) { progress.update(done, expected); }, &g_stop};
}

Result run_and_stamp(const PreparedRun& run, int threads, const std::string& command, double& elapsed) {
  Progress progress;
  const auto created = std::chrono::system_clock::now();
  Result result = execute(run, run_options(threads, progress));
  elapsed = progress.elapsed_s();
  result.provenance.command = command;
  result.provenance.surveymc_version = kVersion;
  result.provenance.git_revision = kGitRevision;
  result.provenance.compiler = kCompiler;
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  result.run = {fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(created))), host,
                elapsed, threads > 0 ? threads : available_threads(), 1};
  return result;
}

int list() {
  for (const Experiment& e : all_experiments())
    fmt::print("{:<24} {}\n{:<24}   after {}\n", e.name, e.summary, "", e.reproduces);
  return kDone;
}

int check(const RunArguments& a) {
  const PreparedRun run = load(a);
  fmt::print("{}\n", run.config.resolved_text());
  fmt::print("# {} sweep point{}, {} trials in all; config hash {}\n", run.points.size(),
             run.points.size() == 1 ? "" : "s", run.total_trials(), run.config.hash());
  return kDone;
}

constexpr const char* kWarningsTable = "warnings";

std::size_t longest_line(const std::string& text) {
  std::size_t longest = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    longest = std::max(longest, end - begin);
    begin = end + 1;
  }
  return longest;
}

/// Tables short and narrow enough to read are printed; the others are a command away.
void print_tables(const Result& result, const std::string& path) {
  constexpr std::size_t kReadable = 30, kWidest = 400;
  std::string left_out;
  for (const Table& t : result.tables) {
    if (t.rows() == 0 || t.name == kWarningsTable) continue;
    const std::string text = t.rows() > kReadable || t.columns.size() > 40 ? "" : format_table(t);
    if (text.empty() || longest_line(text) > kWidest)
      left_out += (left_out.empty() ? "" : ", ") + t.name;
    else
      fmt::print("{}\n", text);
  }
  if (!left_out.empty()) fmt::print("more tables: {}: surveymc show {} TABLE\n", left_out, path);
}

/// The table `warnings`, if a study has one, as the last thing a user reads.
void print_warnings(const Result& result) {
  for (const Table& t : result.tables) {
    if (t.name != kWarningsTable) continue;
    const auto& severity = std::get<std::vector<std::string>>(t.column("severity").values);
    const auto& message = std::get<std::vector<std::string>>(t.column("message").values);
    for (std::size_t row = 0; row < t.rows(); ++row) {
      std::string point;  // columns of the sweep stand in front
      for (const Column& c : t.columns) {
        if (c.name == "severity") break;
        if (const auto* words = std::get_if<std::vector<std::string>>(&c.values))
          point += printable((*words)[row]) + ": ";
        else
          point += fmt::format("{} = {:g}: ", c.name, std::get<std::vector<double>>(c.values)[row]);
      }
      fmt::print("{}: {}{}\n", severity[row], point, printable(message[row]));
    }
  }
}

int report_verdicts(const Result& result, bool check) {
  std::size_t agrees = 0, differs = 0, undecided = 0;
  bool judged = false;
  for (const Table& t : result.tables)
    for (const Column& c : t.columns)
      if (c.name == "verdict") {
        judged = true;
        for (const std::string& v : std::get<std::vector<std::string>>(c.values)) {
          agrees += v == "agrees";
          differs += v == "differs";
          undecided += v == "undecided";
        }
      }
  const std::vector<std::string> unexpected = unexpected_verdicts(result.tables);
  if (!judged) return kDone;  // a study that compares nothing
  fmt::print("verdicts: {} agree, {} differ, {} undecided; {} not as expected\n", agrees, differs, undecided,
             unexpected.size());
  for (const std::string& u : unexpected) fmt::print("  {}\n", u);
  return check && !unexpected.empty() ? kUnexpected : kDone;
}

int run(const RunArguments& a, const std::string& command) {
  const PreparedRun prepared = load(a);
  if (a.trial) {
    const std::uint64_t number = whole_number("--trial", *a.trial),
                        index = whole_number("--point", a.point.value_or("0"));
    require(index < prepared.points.size(), "--point {}: the points of this config are numbered 0 to {}", index,
            prepared.points.size() - 1);
    const StudyPoint& point = *prepared.points[index];
    require(point.trials() > 0, "--trial {}: a config of {} has no trials", number, prepared.experiment.name);
    require(number < point.trials(), "--trial {}: the trials of this config are numbered 0 to {}", number,
            point.trials() - 1);
    fmt::print("{}", point.replay(number));
    return kDone;
  }
  std::filesystem::path output = a.output;
  if (output.empty()) {
    output = std::filesystem::path("results") / (std::filesystem::path(a.config).stem().string() + ".h5");
    std::error_code error;
    std::filesystem::create_directories("results", error);
    if (error) throw IoError(fmt::format("results: cannot be made: {}; name a file with -o", error.message()));
  }
  check_output_path(output);
  spdlog::info("{}: {} point{} of {}, {} trials in all", a.config, prepared.points.size(),
               prepared.points.size() == 1 ? "" : "s", prepared.experiment.name, prepared.total_trials());
  double elapsed = 0;
  const Result result = run_and_stamp(prepared, a.threads, command, elapsed);
  write_result(output, result);
  print_tables(result, output.string());
  const int exit = report_verdicts(result, a.check);
  print_warnings(result);
  if (prepared.total_trials() == 0)
    fmt::print("wrote {} (in {})\n", output.string(), format_duration(elapsed));
  else
    fmt::print("wrote {} ({} trials in {}, {:.3g} trials/s)\n", output.string(), prepared.total_trials(),
               format_duration(elapsed), static_cast<double>(prepared.total_trials()) / elapsed);
  return exit;
}

int show(const std::string& file, const std::string& name, bool csv) {
  const Result result = read_result(file);
  std::vector<Table> all = result.tables;
  all.insert(all.end(), result.samples.begin(), result.samples.end());
  if (name.empty() && !csv) {
    const Provenance& p = result.provenance;
    fmt::print("{}\nexperiment {}, seed {}, {} trials a point; surveymc {} ({}), {}\n\n", printable(p.title),
               p.experiment, p.seed, p.trials, p.surveymc_version, p.git_revision, result.run.created);
    for (const Table& t : result.tables)
      if (t.rows() > 0) fmt::print("{}\n", format_table(t));
    return kDone;
  }
  std::string known;
  for (const Table& t : all) {
    if (t.name == name) {
      fmt::print("{}", csv ? to_csv(t) : format_table(t));
      return kDone;
    }
    known += (known.empty() ? "" : ", ") + t.name;
  }
  throw InputError(name.empty() ? fmt::format("{}: --csv writes one table: name it ({})", file, known)
                                : fmt::format("{}: table {}: not in this file, which has {}", file, name, known));
}

/// The files that were stored beside the config, as the config reader wants them.
struct StoredInputs {
  std::vector<InputTable> tables;
  std::vector<InputText> texts;
  std::vector<InputReference> references;
};

StoredInputs stored_inputs(const Result& result) {
  StoredInputs files;
  for (const InputData& in : result.inputs) {
    const Table& t = in.table;
    if (const auto* words = std::get_if<std::vector<std::string>>(&t.columns.front().values)) {
      if (t.columns.front().name == "line")
        files.texts.push_back({in.path, fmt::format("{}", fmt::join(*words, "\n"))});
      else
        files.references.push_back(
            {in.path, static_cast<std::uint64_t>(std::get<std::vector<std::int64_t>>(t.column("size_bytes").values)[0]),
             words->front(), std::get<std::vector<std::string>>(t.column("header").values)[0]});
      continue;
    }
    InputTable read;
    read.path = in.path;
    for (const Column& c : t.columns) {
      read.names.push_back(c.name);
      read.columns.push_back(std::get<std::vector<double>>(c.values));
    }
    for (std::size_t row = 0; row < t.rows(); ++row) read.lines.push_back(static_cast<int>(row) + 2);
    files.tables.push_back(std::move(read));
  }
  return files;
}

/// `folder`: that of the config, where files are that were too large to be stored.
int rerun(const std::string& file, const std::string& folder, int threads, const std::string& command) {
  const Result stored = read_result(file);
  StoredInputs in = stored_inputs(stored);
  Config config = Config::from_text(stored.provenance.config, file, std::move(in.tables), std::move(in.texts),
                                    std::move(in.references), folder);
  const std::vector<Experiment> all = all_experiments();
  const Experiment& experiment = find_experiment(all, config);
  const PreparedRun prepared = prepare_run(experiment, std::move(config));
  double elapsed = 0;
  const Result again = run_and_stamp(prepared, threads, command, elapsed);
  const std::string before = stored_content_hash(file), now = content_hash(again);
  if (before == now) {
    fmt::print("identical: {} ({} trials in {})\n", now, prepared.total_trials(), format_duration(elapsed));
    return kDone;
  }
  fmt::print("not identical: the file has {}, this run {}\n", before, now);
  if (stored.provenance.git_revision != kGitRevision)
    fmt::print("the file was made by surveymc {} ({}), this is {} ({})\n", stored.provenance.surveymc_version,
               stored.provenance.git_revision, kVersion, kGitRevision);
  if (content_hash(stored) != before) fmt::print("the file's data do not match its own content_hash: it was changed\n");
  return kUnexpected;
}

int guarded_main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_logger_st("surveymc"));
  spdlog::set_pattern("%H:%M:%S %v");

  CLI::App app{"surveymc: Monte-Carlo research workbench for wellbore directional surveying"};
  app.set_version_flag(
      "--version", fmt::format("surveymc {} ({}), {}, {}", kVersion, kGitRevision, kCompiler, name(instruction_set())));
  app.require_subcommand(1);
  RunArguments a;
  std::string file, table, inputs = ".";
  bool csv = false;
  const auto config_options = [&](CLI::App* sub) {
    sub->add_option("config", a.config, "TOML config of an experiment")->required();
    sub->add_option("--set", a.set, "KEY=VALUE: replaces a key of the config, checked like one in the file")
        ->allow_extra_args(false);
    sub->add_option("--trials", a.trials, "replaces the config's number of trials");
    sub->add_option("--seed", a.seed, "replaces the config's seed");
  };
  const auto thread_option = [&](CLI::App* sub) {
    sub->add_option("--threads", a.threads, "number of threads (all cores); the result does not depend on it")
        ->check(CLI::Range(1, 4096));
  };
  CLI::App* list_command = app.add_subcommand("list", "experiments and what each reproduces");
  CLI::App* check_command = app.add_subcommand("check", "validate a config and print it resolved; runs nothing");
  config_options(check_command);
  CLI::App* run_command = app.add_subcommand("run", "run a config and write its result file");
  config_options(run_command);
  thread_option(run_command);
  run_command->add_option("-o,--output", a.output, "result file (results/<config>.h5)")
      ->check([](const std::string& name) { return name.empty() ? "the name is empty" : ""; });
  run_command->add_flag("--check", a.check, "exit with 1 if a verdict is not the expected one");
  run_command->add_option("--trial", a.trial, "replay this one trial (from 0) and print it; writes nothing");
  run_command->add_option("--point", a.point, "sweep point (from 0) for --trial")->needs("--trial");
  CLI::App* show_command = app.add_subcommand("show", "print the tables of a result file");
  show_command->add_option("file", file, "result file")->required();
  show_command->add_option("table", table, "only this table");
  show_command->add_flag("--csv", csv, "as CSV");
  CLI::App* rerun_command = app.add_subcommand("rerun", "repeat a result from what is stored in it and compare");
  rerun_command->add_option("file", file, "result file")->required();
  rerun_command->add_option(
      "--inputs", inputs, "folder of the config, where input files are that were too large to be stored (this folder)");
  thread_option(rerun_command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (app.get_subcommands().empty() && !app.remaining().empty())  // CLI11 would only miss a subcommand
      return app.exit(CLI::ExtrasError(app.remaining())) == 0 ? kDone : kUsage;
    return app.exit(e) == 0 ? kDone : kUsage;
  }

  std::string command = "surveymc";
  for (int i = 1; i < argc; ++i) command += fmt::format(" {}", argv[i]);
  if (*list_command) return list();
  if (*check_command) return check(a);
  if (*run_command) return run(a, command);
  if (*show_command) return show(file, table, csv);
  return rerun(file, inputs, a.threads, command);
}

}  // namespace

int main(int argc, char** argv) {
  const auto fails = [](int exit, const char* kind, const char* what) {  // fmt would throw: the log's disk may be full
    std::fprintf(stderr, "%s%s\n", kind, what);
    return exit;
  };
  std::signal(SIGXFSZ, SIG_IGN);  // a file-size limit then is an error of write(), with a message, and not our death
  try {
    const int exit = guarded_main(argc, argv);
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit;
    return fails(kCannotWrite, "error: standard output: ", "cannot be written");
  } catch (const surveymc::InputError& e) {
    return fails(kBadInput, "error: ", e.what());
  } catch (const surveymc::IoError& e) {
    return fails(kCannotWrite, "error: ", e.what());
  } catch (const surveymc::Interrupted&) {
    return fails(kInterrupted, "interrupted: ", "nothing was written");
  } catch (const std::exception& e) {
    return std::ferror(stdout) != 0 ? fails(kCannotWrite, "error: standard output: ", e.what())
                                    : fails(kInternal, "internal error: ", e.what());
  }
}
