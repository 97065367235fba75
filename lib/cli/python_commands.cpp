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

namespace {

/// An option with the kind of its value, which is none where `value` is "".
OptionWords option(std::vector<std::string> flags, const std::string& value, ValueKind kind,
                   const std::string& description) {
  return {.flags = std::move(flags), .name = "", .value = value, .kind = kind, .description = description};
}

OptionWords flag(const std::string& name, const std::string& description) {
  return option({name}, "", ValueKind::none, description);
}

}  // namespace

const std::vector<PythonCommand>& python_commands() {
  using enum ValueKind;
  static const std::vector<PythonCommand> kCommands = {
      {"plot",
       "result",
       false,
       "result file",
       "draw the figures of a result; plot --help has its options",
       {option({"-o", "--output"}, "FOLDER", folder, "where to write (default: the folder of the result)"),
        option({"--point"}, "N", text, "sweep point of figures that show one, from 0"),
        flag("--3d", "only its wells in space: NAME_3d.html"),
        option({"--quantity"}, "TABLE.NAME", text,
               "what to draw: TABLE.COLUMN, TABLE.QUANTITY or TABLE.QUANTITY.COLUMN of a comparison, or a map; 'max:' "
               "before it: of several rows at a point, such as stations, the largest in place of the last"),
        option({"--at"}, "KEY=VALUE", text, "only points with this value of a key")}},
      {"report",
       "results",
       true,
       "result files, or folders of them",
       "pages of results for a browser; report --help has its options",
       {option({"-o", "--output"}, "FOLDER", folder,
               "where the pages go (report/ in the first folder, or beside the file)"),
        option({"--base"}, "FOLDER", folder, "folder that results are named by (the one that all are in)"),
        option({"--figures"}, "FOLDER", folder, "where figures are kept (figures/ in the folder of the pages)"),
        option({"--jobs"}, "N", text, "figures drawn at a time (2)"),
        flag("--no-figures", "only tables and interactive drawings"),
        option({"--note"}, "NOTE", text, "a sentence for the head of the pages"),
        option({"--templates"}, "FOLDER", folder, "your own templates, in place of those of the same name")}},
      {"import",
       "survey",
       false,
       "text, LAS, WITSML or Excel",
       "a survey or readings in another form to CSV; import --help has its options",
       {option({"-o", "--output"}, "OUT.csv", any_file, "CSV to write (without: nothing is written)"),
        flag("--overwrite", "replace OUT.csv if it exists"),
        flag("--readings", "six-axis readings instead of a survey"),
        option({"--depth-unit"}, "UNIT", text, "m, ft or usft: US survey foot, 1200/3937 m; written as metres"),
        option({"--angle-unit"}, "UNIT", text, "deg, rad or gon"),
        option({"--gravity-unit"}, "UNIT", text, "of accelerometers: g, mg or mps2"),
        option({"--field-unit"}, "UNIT", text, "of magnetometers: nT, uT, gauss or mgauss"),
        option({"--axes"}, "AXES", text,
               "tool axes x, y, z of accelerometers (g) and magnetometers (b) as axes of the file: g=+x+y-z,b=...; "
               "default +x+y+z"),
        option({"--depth-step"}, "METRES", text, "made-up depths of readings that have none (JSON)"),
        option({"--azimuth-reference"}, "NORTH", text, "true, magnetic or grid"),
        option({"--toolface-zero"}, "AXIS", text, "x or y: tool axis that toolface is measured from"),
        flag("--no-toolface", "leave a toolface column out"),
        option({"--decimal"}, "MARK", text, "point or comma"),
        option({"--columns"}, "COLUMNS", text,
               "md=..,inc=..: numbers from 1, or headings; of JSON g=.., b=..: names of lists"),
        option({"--skip-lines"}, "LINES", text, "12,15-20: lines (rows of a sheet) to leave out"),
        option({"--sheet"}, "SHEET", text, "of a workbook"),
        option({"--trajectory"}, "TRAJECTORY", text,
               "of a WITSML file with several: name, uid or number; of a table with a column of wells: the well"),
        option({"--encoding"}, "ENCODING", text, "of text: utf-8, utf-16, latin-1 ..."),
        flag("--accept-doglegs", "take turns of 180 deg and more"),
        flag("--accept-depths", "take depths below 20 km")}},
      {"studies",
       "",
       false,
       "",
       "run all studies that come with surveymc; studies --help has its options",
       {flag("--quick", "few trials; into results/quick"),
        option({"--only"}, "PATTERN", text, "studies whose name fits (thesis/*)"),
        flag("--list", "list the studies and whether they are done; run nothing"),
        option({"--threads"}, "N", text, "of each run (all cores)"), flag("--no-report", "only the results"),
        option({"--output"}, "FOLDER", folder, "where results go (results, or results/quick)")}}};
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
