#pragma once
/// `surveymc man` and `surveymc completion SHELL`: texts made from the words of the command line itself.
#include <string>

#include "cli/command_words.h"

namespace surveymc::cli {

/// The man page, in man(7) macros. Holds no date and no revision, so it changes only with the command line.
std::string man_page(const ProgramWords& program, const std::string& version);

/// The completion script for "bash", "zsh" or "fish". Offers commands, options, configs (*.toml), results (*.h5), and
/// the tables and maps of the result named before.
std::string completion(const ProgramWords& program, const std::string& shell);

}  // namespace surveymc::cli
