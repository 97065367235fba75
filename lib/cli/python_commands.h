#pragma once
/// plot, report, import, studies: commands that the Python side of surveymc carries out (config/python_side.h).
#include <string>
#include <vector>

#include "cli/command_words.h"

namespace surveymc::cli {

struct PythonCommand {
  const char* name;
  const char* argument;  ///< of a positional argument; "": none
  bool repeated;
  const char* argument_is;
  const char* description;
  std::vector<OptionWords> options;  ///< of the Python side, which reads them: for the manual and for completion
};

const std::vector<PythonCommand>& python_commands();
bool is_python_command(const std::string& word);

/// Replaces this process by the command: its streams, signals, and exit code are those of the Python side. Returns only
/// where that cannot be: after a message, with the exit code. `argv`: of the program; argv[1] is the command.
int become_python_command(int argc, char** argv);

}  // namespace surveymc::cli
