#include "text_commands.h"

namespace surveymc {

TextCommands add_text_commands(CLI::App& app, TextArguments& a) {
  CLI::App* man = app.add_subcommand("man", "print the manual page: surveymc man | man -l -");
  CLI::App* completion = app.add_subcommand("completion", "print the completion script of a shell");
  completion->add_option("shell", a.shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  return {man, completion};
}

}  // namespace surveymc
