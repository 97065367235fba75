#pragma once
#include <string>
#include <variant>
#include <vector>

#include "cli/command_words.h"
#include "cli/part_commands.h"
#include "cli/run_setup.h"
#include "cli/show_command.h"

namespace surveymc::cli {

enum class Command { list, check, run, plan, merge, status, show, rerun, man, completion };

/// What a command line asks for (README.md).
struct CommandLine {
  Command command = Command::list;
  RunArguments arguments = {};
  PlanArguments parts_plan = {};
  ShowArguments shown = {};
  std::string shell;  ///< of completion
  std::string file, inputs = ".";
  std::vector<std::string> parts = {};
};

/// The line, or the exit code of one that asks for help or cannot be read; what there is to say of it is printed unless
/// `silent`. `version`: text of --version.
std::variant<CommandLine, int> read_command_line(int argc, char** argv, const std::string& version,
                                                 bool silent = false);

/// All commands and options, as read_command_line knows them.
ProgramWords program_words();

}  // namespace surveymc::cli
