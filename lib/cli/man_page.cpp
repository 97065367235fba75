#include <filesystem>

#include <fmt/format.h>

#include "cli/command_line.h"
#include "cli/command_words.h"
#include "cli/commands.h"
#include "cli/exit_codes.h"
#include "cli/new_files.h"
#include "cli/version_text.h"
#include "config/suggest.h"

namespace surveymc::cli {
namespace {

/// Text as roff prints it: hyphens that are minus signs, backslashes, and no line that begins with a macro's dot.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  return out.starts_with('.') || out.starts_with('\'') ? "\\&" + out : out;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string heading(const OptionWords& option) {
  std::string out;
  for (const std::string& flag : option.flags) out += (out.empty() ? "" : ", ") + bold(flag);
  if (option.flags.empty()) return italic(option.name);
  return option.value.empty() ? out : out + " " + italic(option.value);
}

std::string paragraph(const OptionWords& option) {
  std::string says = option.description;
  const std::string named = option.value + ": ";  // the heading has it already
  if (!option.value.empty() && says.starts_with(named)) says = says.substr(named.size());
  return fmt::format(".TP\n{}\n{}\n", heading(option), roff(says));
}

std::string synopsis(const CommandWords& command) {
  std::string out = ".B surveymc " + roff(command.name) + "\n";
  for (const OptionWords& p : command.positionals)
    out += fmt::format("{}{}{}{}\n", p.required ? "" : "[", italic(p.name), p.repeated ? "..." : "",
                       p.required ? "" : "]");
  for (const OptionWords& o : command.options) {
    if (o.flags.back() == "--help") continue;
    out += o.required ? heading(o) + "\n" : fmt::format("[{}]{}\n", heading(o), o.repeated ? "..." : "");
  }
  return out;
}

std::string head(const std::string& name, const std::string& version, const std::string& summary) {
  std::string capitals = name;
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return fmt::format(
      ".\\\" Made by: surveymc man\n.TH {} 1 \"\" \"surveymc {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n",
      roff(capitals), version, roff(name), roff(summary));
}

/// What no definition says.
constexpr const char* kRest = R"(.SH EXIT STATUS
.PD 0
.TP
.B 0
done
.TP
.B 1
a verdict that is not the expected one (\fB\-\-check\fR), a rerun that differs, or a difference that \fBdiff\fR finds
.TP
.B 64
wrong command line
.TP
.B 65
bad config or data: the message says place, value and rule, and nothing was written
.TP
.B 70
internal error, or out of memory
.TP
.B 71
no more threads, or a processor without AVX2
.TP
.B 74
a result cannot be read or written
.TP
.B 75
interrupted: the message says what is kept and how to go on
.PD
.SH ENVIRONMENT
.TP
.B OMP_NUM_THREADS
the number of threads without \fB\-\-threads\fR; where it is none from 1, as many as cores that the process may use
.TP
.B SURVEYMC_INSTRUCTION_SET
"x86\-64\-v3" asks for the AVX2 kernels on a machine that has AVX\-512. Results are the same bits.
.TP
.B SURVEYMC_PYTHON
the Python of \fBplot\fR, \fBreport\fR, \fBimport\fR and \fBstudies\fR
.SH FILES
.TP
.I results/NAME.h5
where \fBrun\fR writes the result of \fINAME\fR.toml without \fB\-o\fR: HDF5
.SH EXAMPLES
.nf
surveymc new position_covariance \-o well.toml
surveymc run well.toml
surveymc show results/well.h5
surveymc plot results/well.h5
.fi
)";

}  // namespace

std::string man_page(const ProgramWords& program, const std::string& version) {
  const std::string summary = program.description;
  const std::size_t colon = summary.find(": ");
  std::string out = head("surveymc", version, colon == std::string::npos ? summary : summary.substr(colon + 2));
  out +=
      ".SH SYNOPSIS\n.B surveymc\n\\fICOMMAND\\fR [\\fIargument\\fR...]\n"
      ".SH DESCRIPTION\n"
      "Runs experiments from TOML configs: sweeps trajectories, noise levels and error models, estimates sensor "
      "errors\n"
      "on every noisy realisation, predicts the same quantities analytically, and writes comparison tables with a\n"
      "statistical verdict in every row.\n"
      "The same config and seed give the same bits for any number of threads.\n"
      "Each command has a page of its own, \\fBsurveymc\\-run\\fR(1), which \\fBsurveymc man run\\fR prints, too.\n"
      ".SH COMMANDS\n";
  for (const CommandWords& c : program.commands)
    out += fmt::format(".TP 12\n.B {}\n{}\n", roff(c.name), roff(c.description));
  out += ".SH OPTIONS\n";
  for (const OptionWords& o : program.options) out += paragraph(o);
  return out + kRest;
}

std::string command_man_page(const CommandWords& c, const std::string& version) {
  std::string out = head("surveymc-" + c.name, version, c.description);
  out += ".SH SYNOPSIS\n" + synopsis(c);
  if (!c.positionals.empty()) out += ".SH ARGUMENTS\n";
  for (const OptionWords& p : c.positionals) out += paragraph(p);
  std::string options;
  for (const OptionWords& o : c.options)
    if (o.flags.back() != "--help") options += paragraph(o);
  if (!options.empty()) out += ".SH OPTIONS\n" + options;
  return out + ".SH SEE ALSO\n\\fBsurveymc\\fR(1): all commands, exit codes, environment\n";
}

void print_manual(const ManArguments& a) {
  const ProgramWords words = program_words();
  const std::string version = this_build().version;
  if (!a.folder.empty()) {
    NewFiles files;
    const auto add = [&](const std::string& name, const std::string& text) {
      files.add(std::filesystem::path(a.folder) / (name + ".1"), text, {.overwrite = true});
    };
    for (const CommandWords& c : words.commands) add("surveymc-" + c.name, command_man_page(c, version));
    add("surveymc", man_page(words, version));
    files.commit();
    return;
  }
  if (a.command.empty()) return fmt::print("{}", man_page(words, version));
  std::vector<std::string> known;
  for (const CommandWords& c : words.commands) {
    if (c.name == a.command) return fmt::print("{}", command_man_page(c, version));
    known.push_back(c.name);
  }
  throw UsageError(fmt::format("man {}: no command has this name{}", a.command, config::suggestion(a.command, known)));
}

}  // namespace surveymc::cli
