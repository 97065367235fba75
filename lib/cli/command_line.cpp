#include "cli/command_line.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "cli/exit_codes.h"
#include "cli/file_kind.h"
#include "cli/python_commands.h"
#include "config/suggest.h"
#include "render/text.h"

namespace surveymc::cli {
namespace {

constexpr const char* kProgram = "surveymc: Monte-Carlo research workbench for wellbore directional surveying";

/// CLI::Range accepts NaN, and prints an upper bound of infinity with 309 digits.
const CLI::Validator kFinite(
    [](std::string& text) {
      double x = 0;
      return CLI::detail::lexical_cast(text, x) && !std::isfinite(x) ? "must be a finite number, not " + text : "";
    },
    "");

/// CLI::NonNegativeNumber and CLI::PositiveNumber would print their upper bound with 309 digits.
CLI::Validator number_that(bool (*is_right)(double), std::string rule, std::string in_help) {
  return CLI::Validator(
      [is_right, rule = std::move(rule)](std::string& text) {
        double x = 0;
        return CLI::detail::lexical_cast(text, x) && is_right(x)
                   ? ""
                   : fmt::format("must be a number{}, not {}", rule, text);
      },
      std::move(in_help));
}

const CLI::Validator kNotNegative = number_that([](double x) { return x >= 0; }, ", 0 or more", "NONNEGATIVE");
const CLI::Validator kAboveZero = number_that([](double x) { return x > 0; }, " > 0", "");

/// Gives `app` the commands and options of the program; parsing fills `line`, which must live as long.
void define(CLI::App& app, CommandLine& line, const std::function<std::string()>& version) {
  app.set_version_flag("--version", version);
  app.require_subcommand(1);
  RunArguments& a = line.arguments;
  const auto command = [&](Command which, const char* name, const char* description) {
    CLI::App* sub = app.add_subcommand(name, description);
    sub->callback([&line, which] { line.command = which; });
    return sub;
  };
  const auto config_changes = [&](CLI::App* sub) {
    sub->add_option("--set", a.set, "KEY=VALUE: replaces a key of the config, checked like one in the file")
        ->allow_extra_args(false);
    sub->add_option("--trials", a.trials, "replaces the config's number of trials: 20000, 2e4, 20k or 2M");
    sub->add_option("--seed", a.seed, "replaces the config's seed");
  };
  const auto config_options = [&](CLI::App* sub) {
    sub->add_option("config", a.config, "TOML config of an experiment")->required();
    config_changes(sub);
  };
  const auto thread_option = [&](CLI::App* sub) {
    sub->add_option("--threads", a.threads, "number of threads (default: all cores); results do not depend on it")
        ->check(CLI::Range(1, 4096));
  };
  const auto units_option = [](CLI::App* sub, std::string& units) {
    return sub
        ->add_option("--units", units, "m or ft: unit of lengths in printed tables (default: m); files have metres")
        ->check(CLI::IsMember({"m", "ft"}));
  };
  const auto quiet_option = [&](CLI::App* sub) {
    sub->add_flag("-q,--quiet", a.quiet, "print nothing but warnings and errors; the exit code says the rest");
  };
  const auto answer_options = [&](CLI::App* sub) {
    CLI::Option* verbose = sub->add_flag("-v,--verbose", a.verbose, "print the tables, too");
    sub->add_flag("--json", a.json, "print answer, verdicts and warnings as JSON, and nothing else")->excludes(verbose);
  };
  const auto overwrite_option = [&](CLI::App* sub) {
    return sub->add_flag("--overwrite", a.overwrite,
                         "replace an existing result (default: it is kept as NAME.1.h5, or the next free number)");
  };
  const auto compress_option = [&](CLI::App* sub) {
    return sub
        ->add_option(
            "--compress", a.compression,
            "compress the numbers of the result file, at this level from 1 (fast) to 9 (default: 0, not at all)")
        ->check(CLI::Range(0, 9));
  };
  command(Command::list, "list", "experiments and what each reproduces");
  CLI::App* keys = command(Command::keys, "keys", "every key of an experiment: type, unit, default, rule, example");
  keys->add_option("experiment", line.keys.experiment, "name of an experiment (without: the list of them)");
  keys->add_flag("--csv", line.keys.csv, "as CSV");
  CLI::App* schema = command(Command::schema, "schema", "JSON Schema of an experiment's configs, for editors");
  schema->add_option("experiment", line.schema_of, "name of an experiment: surveymc list has them")->required();
  CLI::App* made = command(Command::new_config, "new", "a commented config of an experiment, for your own well");
  made->add_option("experiment", line.made.experiment, "name of an experiment: surveymc list has them")->required();
  made->add_option(
          "-o,--output", line.made.output,
          "config to write, with its schema and example data beside it; never over a file (default: the config is "
          "printed)")
      ->check([](const std::string& name) { return name.empty() ? "the name is empty" : ""; });
  CLI::App* models = command(Command::models, "models", "error models of survey tools, or one of them as TOML to edit");
  models->add_option("model", line.models.name, "name of an error model: print it with its functions");
  models->add_option("--file", line.models.file, "models of this TOML file, not those that come with the program");
  CLI::App* check = command(Command::check, "check", "validate a config and print it resolved; runs nothing");
  config_options(check);
  quiet_option(check);
  CLI::App* run = command(Command::run, "run", "run a config and write its result file");
  config_options(run);
  thread_option(run);
  CLI::Option* output = run->add_option("-o,--output", a.output, "result file (default: results/<config>.h5)");
  output->check([](const std::string& name) { return name.empty() ? "the name is empty" : ""; });
  CLI::Option* units = units_option(run, a.units);
  CLI::Option* overwrite = overwrite_option(run);
  CLI::Option* compress = compress_option(run);
  quiet_option(run);
  answer_options(run);
  CLI::Option* checks = run->add_flag("--check", a.check, "exit with 1 if a verdict is not the expected one");
  CLI::Option* trial =
      run->add_option("--trial", a.trial, "replay this one trial (from 0) and print it; writes nothing");
  run->add_option("--point", a.point,
                  "run only this sweep point (from 0), or the points FIRST:END or FIRST:END:STEP (END not among them); "
                  "writes one part file, or nothing with --trial");
  CLI::Option* shard = run->add_option("--shard", a.shard,
                                       "I/N: run only slice I (from 0) of N slices of the trials; writes a part file");
  CLI::Option* array =
      run->add_flag("--array", a.array, "run the part of this Slurm array task: a point, or with --shards a shard");
  run->add_option("--shards", a.shards,
                  "with --array: number of shards in all; the task runs shard SLURM_ARRAY_TASK_ID");
  CLI::Option* resume =
      run->add_flag("--resume", a.resume, "go on from the journal of an interrupted run, if there is one");
  for (CLI::Option* of_result : {output, units, overwrite, compress, checks, shard, array, resume})
    trial->excludes(of_result);
  run->add_option("--max-seconds", a.max_seconds, "stop after this time, keep finished blocks, exit with 75")
      ->check(kFinite)
      ->check(kAboveZero);
  run->add_option("--checkpoint-seconds", a.checkpoint_seconds,
                  "time between writes of finished blocks to the journal (default: 5)")
      ->check(kFinite)
      ->check(CLI::Range(0.001, 1e6));
  CLI::App* plan = command(Command::plan, "plan", "parts of a config: how many, and which are missing");
  config_options(plan);
  CLI::Option* count = plan->add_flag("--count", line.parts_plan.count, "print how many parts there are");
  CLI::Option* missing = plan->add_option("--missing", line.parts_plan.folder,
                                          "print the parts that are not in this folder, as a Slurm array list");
  count->excludes(missing);
  plan->add_option("--groups", line.parts_plan.groups,
                   "divide the sweep into this many ranges of points that cost about the same, and print them a line "
                   "each, for run --point; with --count or --missing, the parts are these ranges, numbered from 0");
  plan->add_option("--shards", a.shards, "divide the run into this many shards, not into sweep points");
  CLI::App* merge =
      command(Command::merge, "merge",
              "put part files together to the result of the whole run; or results, rounds of one sweep, to one");
  merge->add_option("parts", line.parts, "part files, or folders of them")->required();
  merge->add_option("-o,--output", a.output, "result file")->required();
  merge->add_option("--inputs", line.inputs,
                    "folder of the config, with input files that were too large to be stored (default: where it was)");
  merge->add_flag("--part", line.to_part, "write a larger part file, to be merged later, and no result");
  units_option(merge, a.units);
  overwrite_option(merge);
  compress_option(merge);
  quiet_option(merge);
  answer_options(merge);
  merge->add_flag("--check", a.check, "exit with 1 if a verdict is not the expected one");
  CLI::App* status = command(Command::status, "status", "how far a run is, by the work that it has kept");
  status
      ->add_option("place", a.config, "config of the run, with the options that it was given; or folder of part files")
      ->required();
  config_changes(status);
  status->add_option("-o,--output", a.output, "that of the run: its result, or the folder of its parts");
  status->add_flag("--watch", line.watched.watch,
                   "look again and again until all is done; Ctrl-C ends only the looking");
  status->add_option("--every", line.watched.every_s, "with --watch: seconds between two looks (default: 5)")
      ->check(kFinite)
      ->check(CLI::Range(0.1, 3600.0));
  status
      ->add_option("--page", line.watched.page, "FILE: write a page for a browser, too; with --watch it renews itself")
      ->check([](const std::string& name) { return name.empty() ? "the name is empty" : ""; });
  CLI::App* show = command(Command::show, "show", "print what is in a result file");
  show->add_option("file", line.shown.file, "result file")->required();
  CLI::Option* name = show->add_option("table", line.shown.name, "only this table or map");
  CLI::Option* only_list = show->add_flag("--list", line.shown.list, "with --json: tables without their rows");
  show->add_flag("-v,--verbose", line.shown.verbose, "the tables, too")->excludes(name)->excludes(only_list);
  CLI::Option* cost = show->add_flag("--cost", line.shown.cost,
                                     "what the rows cost: processor time, figure of merit, seconds to a verdict");
  CLI::Option* csv = show->add_flag("--csv", line.shown.csv, "as CSV");
  CLI::Option* json = show->add_flag("--json", line.shown.json, "as JSON");
  show->add_option("--rows", line.shown.rows,
                   "at most this many rows of a table, from both ends; 0 for all (default: 40)")
      ->check(kNotNegative)
      ->excludes(csv)
      ->excludes(json);
  show->add_flag("--unchecked", line.shown.unchecked,
                 "do not verify the file: of a large one no more is read than is shown");
  units_option(show, line.shown.units)->excludes(csv)->excludes(json);
  csv->excludes(json);
  only_list->excludes(name)->excludes(csv);
  cost->excludes(name)->excludes(only_list);
  CLI::App* diff = command(Command::diff, "diff", "what differs beyond chance between two results");
  diff->add_option("file_a", line.compared.a, "result file")->required();
  diff->add_option("file_b", line.compared.b, "another one of the same experiment")->required();
  diff->add_option("--level", line.compared.level,
                   "probability of any false difference, over all rows together (default: 0.05)")
      ->check(kFinite)
      ->check(CLI::Range(1e-12, 0.5));
  diff->add_option("--tolerance", line.compared.tolerance,
                   "of the same draws: standard errors that a value may have changed (default: 0)")
      ->check(kFinite)
      ->check(kNotNegative);
  CLI::Option* diff_csv = diff->add_flag("--csv", line.compared.csv, "every row as CSV");
  CLI::Option* diff_json = diff->add_flag("--json", line.compared.json, "every row as JSON");
  diff_csv->excludes(diff_json);
  CLI::App* cite = command(Command::cite, "cite", "how to cite a result: the program, its study and their sources");
  cite->add_option("file", line.cited.file, "result file")->required();
  cite->add_flag("--bibtex", line.cited.bibtex, "as BibTeX");
  CLI::App* refine =
      command(Command::refine, "refine", "the next points of a sweep, along the boundary that its [refine] names");
  refine->add_option("file", line.refined.file, "result of a sweep over two or more numeric keys")->required();
  refine->add_option("-o,--output", line.refined.output, "config to write, with its table of points beside it")
      ->required();
  refine->add_flag("--overwrite", line.refined.overwrite, "replace an existing config and table");
  CLI::App* rerun =
      command(Command::rerun, "rerun", "repeat a result from the config and inputs stored in it, and compare");
  rerun->add_option("file", line.file, "result file")->required();
  rerun->add_option("--inputs", line.inputs,
                    "folder of the config, with input files that were too large to be stored (default: this folder)");
  thread_option(rerun);
  quiet_option(rerun);
  for (const PythonCommand& p : python_commands()) {
    CLI::App* sub = command(Command::python, p.name, p.description);
    if (p.repeated)
      sub->add_option(p.argument, line.parts, p.argument_is);
    else if (*p.argument != '\0')
      sub->add_option(p.argument, line.file, p.argument_is)->required();
  }
  CLI::App* man = command(Command::man, "man", "print the manual page: surveymc man | man -l -");
  man->add_option("command", line.manual.command, "print the page of this command");
  man->add_option("-o,--output", line.manual.folder, "FOLDER: write all pages there");
  CLI::App* completion = command(Command::completion, "completion", "print the completion script of bash");
  completion->add_option("shell", "bash")->required()->check(CLI::IsMember({"bash"}));
}

/// The kind of the arguments with these names; any other argument is text.
ValueKind kind_of(const std::string& name) {
  static const std::map<std::string, ValueKind> kKinds = {
      {"config", ValueKind::config_file},    {"place", ValueKind::config_file},  {"file", ValueKind::result_file},
      {"file_a", ValueKind::result_file},    {"file_b", ValueKind::result_file}, {"parts", ValueKind::result_file},
      {"output", ValueKind::result_file},    {"inputs", ValueKind::folder},      {"folder", ValueKind::folder},
      {"missing", ValueKind::folder},        {"result", ValueKind::result_file}, {"results", ValueKind::result_file},
      {"survey", ValueKind::any_file},       {"table", ValueKind::table},        {"shell", ValueKind::shell},
      {"experiment", ValueKind::experiment}, {"model", ValueKind::model},        {"command", ValueKind::command},
      {"set", ValueKind::key_value}};
  const auto found = kKinds.find(name);
  return found == kKinds.end() ? ValueKind::text : found->second;
}

/// "KEY=VALUE" of "KEY=VALUE: replaces a key": capitals and signs before a colon name the value.
std::string placeholder_in(const std::string& description) {
  const std::string head = description.substr(0, description.find(':'));
  const bool capitals = std::all_of(head.begin(), head.end(), [](char c) {
    return std::isupper(static_cast<unsigned char>(c)) || std::ispunct(static_cast<unsigned char>(c));
  });
  return head.size() < description.size() && capitals ? head : "";
}

std::string placeholder(const CLI::Option& option, ValueKind kind, const std::string& name) {
  const std::string said = placeholder_in(option.get_description());
  if (!said.empty()) return said;
  if (kind == ValueKind::any_file || kind == ValueKind::config_file || kind == ValueKind::result_file) return "FILE";
  if (kind == ValueKind::folder) return "FOLDER";
  if (option.get_type_name().starts_with("INT") || option.get_type_name().starts_with("UINT")) return "N";
  std::string capitals = name;
  for (char& c : capitals) c = c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return capitals;
}

OptionWords words_of(const CLI::Option& option) {
  OptionWords words;
  for (const std::string& s : option.get_snames()) words.flags.push_back("-" + s);
  for (const std::string& l : option.get_lnames()) words.flags.push_back("--" + l);
  const std::string name = option.get_positional()       ? option.get_name(true)
                           : option.get_lnames().empty() ? option.get_snames().front()
                                                         : option.get_lnames().front();
  if (option.get_positional()) words.name = name;
  if (option.get_items_expected_max() > 0) {
    words.kind = !option.get_positional() && name == "file" ? ValueKind::config_file : kind_of(name);
    words.value = placeholder(option, words.kind, name);
  }
  words.required = option.get_required();
  words.repeated = option.get_items_expected_max() > 1;
  words.description = option.get_description();
  return words;
}

CommandWords words_of(const CLI::App& app) {
  CommandWords words{app.get_name(), app.get_description(), {}, {}};
  for (const CLI::Option* option : app.get_options())
    (option->nonpositional() ? words.options : words.positionals).push_back(words_of(*option));
  return words;
}

/// What a command line without any word is answered: what the program is for, and the way to a first result.
constexpr const char* kFirstSteps =
    R"(surveymc computes how uncertain surveyed wells are: by the error models of the survey
tools, and by Monte Carlo, which tells where their formulas hold. To begin with your own well:

  surveymc new position_covariance -o well.toml   a config with an example survey: put in yours
  surveymc run well.toml                          computes; the result is results/well.h5
  surveymc show results/well.h5                   prints what is in it
  surveymc plot results/well.h5                   draws it

Other questions: surveymc list. All commands: surveymc --help.
)";

/// What is wrong with the first word that nobody expected, and what may be meant; "" if there is none.
std::string unknown_word(const CLI::App& app) {
  const std::vector<const CLI::App*> chosen = app.get_subcommands([](const CLI::App* sub) { return sub->parsed(); });
  const CLI::App& at = chosen.empty() ? app : *chosen.front();
  std::vector<std::string> left = app.remaining(true);
  if (left.empty()) return "";
  // An option before words: what follows an unknown option is its value, or was taken for another word.
  const auto option = std::find_if(left.begin(), left.end(), [](const std::string& w) { return w.starts_with('-'); });
  const std::string written = option == left.end() ? left.front() : *option,
                    word = written.substr(0, written.find('='));
  std::vector<std::string> known;
  const bool is_option = word.starts_with('-');
  if (is_option) {
    for (const CLI::Option* o : at.get_options())
      for (const std::string& name : o->get_lnames()) known.push_back("--" + name);
  } else if (chosen.empty()) {
    for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
      known.push_back(sub->get_name());
  }
  std::string near = config::nearest(word.starts_with("--") || !is_option ? word : "-" + word, known);
  if (near.empty() && is_option && !chosen.empty()) {  // before the command's name, or of another command
    for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
      for (const CLI::Option* o : sub->get_options())
        for (const std::string& name : o->get_lnames())
          if ("--" + name == word) near = fmt::format("{} of surveymc {}", word, sub->get_name());
  }
  if (const FileKind kind = chosen.empty() && !is_option ? kind_of_file(written) : FileKind::unknown;
      kind != FileKind::unknown)
    return fmt::format("surveymc: {} is not expected: a command comes first, and this is {}",
                       render::printable(written), what_to_do(written, kind));
  std::error_code error;
  const bool is_file = is_option && std::filesystem::exists(written, error);
  const std::string hint = is_file        ? fmt::format(": the file of this name is ./{}", render::printable(written))
                           : near.empty() ? ""
                                          : fmt::format(": did you mean {}?", near);
  return fmt::format("surveymc{}: {} is not expected{}", chosen.empty() ? "" : " " + at.get_name(),
                     render::printable(written), hint);
}

}  // namespace

std::variant<CommandLine, int> read_command_line(int argc, char** argv, const std::function<std::string()>& version,
                                                 bool silent) {
  CommandLine line;
  CLI::App app{kProgram};
  define(app, line, version);
  std::ostringstream unheard;
  std::ostream& out = silent ? unheard : std::cout;
  std::ostream& errors = silent ? unheard : std::cerr;
  if (argc <= 1) {
    errors << kFirstSteps;
    return kUsage;
  }
  try {
    app.parse(argc, argv);
    return line;
  } catch (const CLI::ParseError& e) {
    const std::string fault = unknown_word(app);
    if (!fault.empty() && e.get_exit_code() != 0) {  // it may be why CLI11 misses another word
      errors << fault << "\nRun with --help for more information.\n";
      return kUsage;
    }
    return app.exit(e, out, errors) == 0 ? kDone : kUsage;
  }
}

ProgramWords program_words() {
  CommandLine line;
  CLI::App app{kProgram};
  define(app, line, [] { return std::string(); });
  ProgramWords words{app.get_description(), words_of(app).options, {}};
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    words.commands.push_back(words_of(*sub));
  for (const PythonCommand& p : python_commands())
    for (CommandWords& c : words.commands)
      if (c.name == p.name) c.options.insert(c.options.end(), p.options.begin(), p.options.end());
  return words;
}

}  // namespace surveymc::cli
