#pragma once
/// Commands and options of the program as plain words, read from CLI11's definitions: what the man page and the shell
/// completions are made of. Nothing is listed by hand.
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace surveymc {

/// What a value is, for a shell to offer.
enum class ValueKind { none, text, config_file, result_file, folder, table, shell };

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

/// The program itself: name "", without positional arguments.
CommandWords program_words(const CLI::App& app);
/// Its commands, in the order in which they were added.
std::vector<CommandWords> command_words(const CLI::App& app);

}  // namespace surveymc
