#pragma once
/// Commands and options of the program as plain words, read from the definitions of the command line. `surveymc man`
/// and `surveymc completion bash` make their texts of them, so that nothing is listed by hand.
#include <string>
#include <vector>

namespace surveymc::cli {

/// The kind of an option's value, so that a shell can offer values.
enum class ValueKind {
  none,
  text,
  any_file,
  config_file,
  result_file,
  folder,
  table,
  shell,
  experiment,
  model,      ///< name of an error model
  command,    ///< of the program
  key_value,  ///< KEY=VALUE of a config
};

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

/// The page surveymc(1), in man(7) macros: what the program is for, its commands in a line each, exit codes. Holds no
/// date and no revision, so it changes only with the command line.
std::string man_page(const ProgramWords& program, const std::string& version);

/// The page surveymc-COMMAND(1): its arguments and options.
std::string command_man_page(const CommandWords& command, const std::string& version);

/// The completion script for bash. Offers commands, options, configs (*.toml), results (*.h5), the tables and maps of
/// the result named before, names of error models, and keys of the config named before, with their words, after --set.
std::string bash_completion(const ProgramWords& program);

}  // namespace surveymc::cli
