/// The program: sets up the process, chooses the command, turns exceptions into exit codes.
#include "cli/program.h"

#include <cstdio>
#include <new>
#include <string>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "base/error.h"
#include "base/shell_word.h"
#include "cli/command_line.h"
#include "cli/command_words.h"
#include "cli/commands.h"
#include "cli/exit_codes.h"
#include "cli/file_kind.h"
#include "cli/log.h"
#include "cli/process_setup.h"
#include "cli/python_commands.h"
#include "cli/rank_work.h"
#include "cli/screen.h"
#include "cli/signals.h"
#include "cli/version_text.h"
#include "montecarlo/workers.h"

namespace surveymc::cli {
namespace {

/// Throws UsageError if a file of the command line is of a kind that its command does not take.
void refuse_other_kinds(const CommandLine& line) {
  const auto wants = [](const char* command, FileKind kind, std::initializer_list<std::string> files) {
    for (const std::string& file : files) refuse_other_kind(command, file, kind);
  };
  switch (line.command) {
    case Command::check:
      return wants("check", FileKind::config, {line.arguments.config});
    case Command::run: {
      catch_signals();
      const EndsBySignal guard(nullptr, EndMessage::at_once());  // a disk may be slow
      return wants("run", FileKind::config, {line.arguments.config});
    }
    case Command::plan:
      return wants("plan", FileKind::config, {line.arguments.config});
    case Command::show:
      return wants("show", FileKind::result, {line.shown.file});
    case Command::diff:
      return wants("diff", FileKind::result, {line.compared.a, line.compared.b});
    case Command::cite:
      return wants("cite", FileKind::result, {line.cited.file});
    case Command::refine:
      return wants("refine", FileKind::result, {line.refined.file});
    case Command::rerun:
      return wants("rerun", FileKind::result, {line.file});
    case Command::models:
      return wants("models --file", FileKind::error_models, {line.models.file});
    case Command::merge:
      for (const std::string& file : line.parts)
        if (line.parts.size() == 1 || kind_of_file(file) != FileKind::result)  // several results: rounds of a sweep
          refuse_other_kind("merge", file, FileKind::part);
      return;
    default:
      return;
  }
}

/// Runs the command of the command line; its exit code.
int run_command(int argc, char** argv, const std::vector<study::Experiment>& studies, montecarlo::Workers& workers,
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
  refuse_other_kinds(line);
  switch (line.command) {
    case Command::list:
      return fmt::print("{}", list_text(studies)), kDone;
    case Command::keys:
      return print_keys(studies, line.keys), kDone;
    case Command::schema:
      return print_schema(studies, line.schema_of), kDone;
    case Command::new_config:
      return new_config(studies, line.made), kDone;
    case Command::models:
      return fmt::print("{}", printable_toml(models_text(line.models))), kDone;
    case Command::check:
      return check_config(a);
    case Command::run:
      return run_config(a, command);
    case Command::plan:
      return plan_parts(a, line.parts_plan);
    case Command::merge:
      return merge_files(a, line.parts, line.inputs, line.to_part);
    case Command::status:
      return status_of(a, line.watched);
    case Command::show:
      return show(line.shown), kDone;
    case Command::diff:
      return diff_results(line.compared);
    case Command::cite:
      return cite_result(studies, line.cited), kDone;
    case Command::refine:
      return refine_result(line.refined);
    case Command::rerun:
      return rerun_result(line.file, line.inputs.empty() ? "." : line.inputs, a, command);
    case Command::python:
      throw UsageError(fmt::format("{}: runs on one process: surveymc {}", argv[1], argv[1]));
    case Command::man:
      return print_manual(line.manual), kDone;
    case Command::completion:
      return fmt::print("{}", bash_completion(program_words())), kDone;
  }
  return kInternal;
}

/// run_command() with every exception reported and turned into its exit code.
int main_with_exit_codes(int argc, char** argv, ListStudies studies, montecarlo::Workers& workers,
                         const montecarlo::Messages* messages, const std::string& mpi) {
  const auto fails = [](int exit, const char* kind, const char* what) {  // fmt would throw: the log's disk may be full
    std::fprintf(stderr, "%s%s\n", kind, printable_lines(what).c_str());
    return exit;
  };
  try {
    const int exit = run_command(argc, argv, studies(), workers, messages, mpi);
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
  } catch (const std::bad_alloc&) {  // no memory for anything else either
    std::fputs(kOutOfMemory, stderr);
    return kInternal;
  } catch (const std::exception& e) {
    return std::ferror(stdout) != 0 ? fails(kCannotWrite, "error: standard output: ", e.what())
                                    : fails(kInternal, "internal error: ", e.what());
  }
}

}  // namespace

int program_main(int argc, char** argv, ListStudies studies, montecarlo::Messages* messages, const std::string& mpi) {
  if (!messages && argc > 1 && is_python_command(argv[1])) return become_python_command(argc, argv);
  if (const std::string fault = set_up_process(); !fault.empty()) {
    std::fprintf(stderr, "error: %s\n", fault.c_str());
    return kNoMachine;
  }
  try {
    if (messages && messages->rank() > 0) return work_for_rank_0(studies(), *messages, argc, argv);
    montecarlo::Workers workers(messages);
    const int exit = main_with_exit_codes(argc, argv, studies, workers, messages, mpi);
    workers.end(exit);
    return exit;
  } catch (const std::exception& e) {  // between ranks: a rank that went on alone would wait for ever
    std::fprintf(stderr, "internal error: rank %d: %s\n", messages ? messages->rank() : 0, e.what());
    if (messages) messages->abort(kInternal);
    return kInternal;
  }
}

}  // namespace surveymc::cli
