#pragma once
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "part_commands.h"
#include "run_setup.h"

namespace surveymc {

/// Commands and options of the program (README.md), and what they were given.
struct CommandLine {
  explicit CommandLine(const std::string& version);
  CommandLine(const CommandLine&) = delete;  // the app points to the members

  CLI::App app{"surveymc: Monte-Carlo research workbench for wellbore directional surveying"};
  CLI::App *list, *check, *run, *plan, *merge, *status, *show, *rerun;
  RunArguments arguments;
  PlanArguments parts_plan;
  std::string file, table, inputs = ".";
  std::vector<std::string> parts;
  bool csv = false;
};

}  // namespace surveymc
