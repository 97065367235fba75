#pragma once
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "part_commands.h"
#include "run_setup.h"
#include "show_command.h"
#include "text_commands.h"

namespace surveymc {

/// Commands and options of the program (README.md), and what they were given.
struct CommandLine {
  explicit CommandLine(const std::string& version);
  CommandLine(const CommandLine&) = delete;  // the app points to the members

  CLI::App app{"surveymc: Monte-Carlo research workbench for wellbore directional surveying"};
  CLI::App *list, *check, *run, *plan, *merge, *status, *show, *rerun;
  RunArguments arguments;
  PlanArguments parts_plan;
  ShowArguments shown;
  TextArguments text_arguments;
  TextCommands texts{};
  std::string file, inputs = ".";
  std::vector<std::string> parts;
};

}  // namespace surveymc
