#include "cli/python_commands.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <system_error>

#include <fmt/format.h>

#include "base/error.h"
#include "cli/exit_codes.h"
#include "cli/file_kind.h"
#include "cli/screen.h"
#include "config/python_side.h"

namespace surveymc::cli {
namespace {

/// Throws UsageError if a word of the command is a file that neither plot nor report takes.
void refuse_other_files(const std::vector<std::string>& words) {
  if (words[0] != "plot" && words[0] != "report") return;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const bool is_value = words[i - 1].starts_with('-'), is_option = words[i].starts_with('-');
    if (!is_value && !is_option) refuse_other_kind(words[0], words[i], FileKind::result);
  }
}

}  // namespace

const std::vector<PythonCommand>& python_commands() {
  static const std::vector<PythonCommand> kCommands = {
      {"plot", "result", false, "result file", "draw the figures of a result; plot --help has its options"},
      {"report", "results", true, "result files, or folders of them",
       "pages of results for a browser; report --help has its options"},
      {"import", "survey", false, "text, LAS, WITSML or Excel",
       "a survey or readings in another form to CSV; import --help has its options"},
      {"studies", "", false, "", "run all studies that come with surveymc; studies --help has its options"}};
  return kCommands;
}

bool is_python_command(const std::string& word) {
  const std::vector<PythonCommand>& all = python_commands();
  return std::any_of(all.begin(), all.end(), [&](const PythonCommand& c) { return word == c.name; });
}

int become_python_command(int argc, char** argv) {
  const auto fails = [](int exit, const std::string& text) {
    std::fprintf(stderr, "error: %s\n", printable_lines(text).c_str());
    return exit;
  };
  try {
    const std::vector<std::string> words(argv + 1, argv + argc);
    refuse_other_files(words);
    std::vector<std::string> command = config::python_command(words);
    setenv("SURVEYMC", config::own_path().c_str(), 1);  // the program that it runs in turn
    std::vector<char*> arguments;
    for (std::string& word : command) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    return fails(kNoMachine, fmt::format("surveymc {}: {}: cannot be run: {}", words[0], command[0],
                                         std::generic_category().message(errno)));
  } catch (const UsageError& e) {
    return fails(kUsage, e.what());
  } catch (const InputError& e) {
    return fails(kBadInput, e.what());
  } catch (const std::exception& e) {
    return fails(kNoMachine, e.what());
  }
}

}  // namespace surveymc::cli
