#pragma once
/// `surveymc man` and `surveymc completion SHELL`: texts made from the definitions of the command line itself.
#include <string>

#include <CLI/CLI.hpp>

namespace surveymc {

struct TextArguments {
  std::string shell;
};

struct TextCommands {
  CLI::App *man, *completion;
};

TextCommands add_text_commands(CLI::App& app, TextArguments& a);

/// The man page, in man(7) macros. Holds no date and no revision, so it changes only with the command line.
std::string man_page(const CLI::App& app, const std::string& version);

/// The completion script for "bash", "zsh" or "fish". Offers commands, options, configs (*.toml), results (*.h5), and
/// the tables and maps of the result named before.
std::string completion(const CLI::App& app, const std::string& shell);

}  // namespace surveymc
