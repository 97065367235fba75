#pragma once
/// Commands and options of the program as plain words, read from the definitions of the command line. The man page and
/// the shell completions are made of them, so that nothing is listed by hand.
#include <string>
#include <vector>

namespace surveymc::cli {

/// The kind of an option's value, so that a shell can offer values.
enum class ValueKind { none, text, config_file, result_file, folder, table, shell, experiment };

struct OptionWords {
  std::vector<std::string> flags;  ///< "-o", "--output"; empty for a positional argument
  std::string name;                ///< of a positional argument
  std::string value;               ///< placeholder: "N", "FILE"; "" for a flag
  ValueKind kind = ValueKind::none;
  bool required = false, repeated = false;
  std::string description;
};

struct CommandWords {
  std::string name, description;
  std::vector<OptionWords> options, positionals;
};

struct ProgramWords {
  std::string description;
  std::vector<OptionWords> options;    ///< of the program itself
  std::vector<CommandWords> commands;  ///< in the order in which they were added
};

}  // namespace surveymc::cli
