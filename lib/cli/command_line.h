#pragma once
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "cli/command_words.h"
#include "cli/commands.h"
#include "cli/run_arguments.h"

namespace surveymc::cli {

enum class Command {
  list,
  keys,
  schema,
  new_config,
  models,
  check,
  run,
  plan,
  merge,
  status,
  show,
  diff,
  cite,
  refine,
  rerun,
  python,
  man,
  completion
};

/// The command and options of a command line (docs/using.md).
struct CommandLine {
  Command command = Command::list;
  RunArguments arguments = {};
  PlanArguments parts_plan = {};
  StatusArguments watched = {};
  ShowArguments shown = {};
  DiffArguments compared = {};
  RefineArguments refined = {};
  ModelsArguments models = {};
  KeysArguments keys = {};
  std::string schema_of;  ///< name of an experiment
  ManArguments manual = {};
  NewArguments made = {};
  CiteArguments cited = {};
  std::string file, inputs;  ///< `inputs`: "" if it was not given
  std::vector<std::string> parts = {};
  bool to_part = false;  ///< of merge
};

/// The command line, or the exit code if it asks for help or is wrong; help and errors are printed unless `silent`.
/// `version`: makes the text of --version, where it is asked for.
std::variant<CommandLine, int> read_command_line(int argc, char** argv, const std::function<std::string()>& version,
                                                 bool silent = false);

/// All commands and options, as read_command_line knows them.
ProgramWords program_words();

}  // namespace surveymc::cli
