#include <fmt/format.h>

#include "cli/command_words.h"

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

constexpr const char* kRest = R"(.SH EXIT STATUS
.TP
.B 0
done
.TP
.B 1
a verdict that is not the expected one, with \fB\-\-check\fR; a rerun that differs; or a difference that
\fBdiff\fR finds
.TP
.B 64
wrong command line; the message names the word and what may be meant
.TP
.B 65
bad config or data; the message says place, value and rule, and nothing was written
.TP
.B 70
internal error, or out of memory
.TP
.B 71
the system starts no more threads: fewer with \fB\-\-threads\fR; or a processor without AVX2
.TP
.B 74
a result cannot be read or written
.TP
.B 75
interrupted, within a second of the signal; the message says what is kept and how to go on
.SH ENVIRONMENT
.TP
.B OMP_NUM_THREADS
the number of threads without \fB\-\-threads\fR; where it is none from 1, as many as cores that the process may use
.TP
.B SURVEYMC_INSTRUCTION_SET
"x86\-64\-v3" asks for the AVX2 kernels on a machine that has AVX\-512. Results are the same bits.
.SH FILES
.TP
.I results/NAME.h5
where \fBrun\fR writes the result of \fINAME\fR.toml without \fB\-o\fR. HDF5; docs/results\-format.md describes
every table, docs/keys.md every key.
.SH EXAMPLES
.nf
surveymc run configs/thesis/test4.toml
surveymc show results/test4.h5
surveymc show results/test4.h5 position
surveymc show results/test4.h5 position \-\-csv > position.csv
surveymc rerun results/test4.h5
.fi
)";

}  // namespace

std::string man_page(const ProgramWords& program, const std::string& version) {
  const std::vector<CommandWords>& commands = program.commands;
  std::string out =
      fmt::format(".\\\" Made by: surveymc man\n.TH SURVEYMC 1 \"\" \"surveymc {}\" \"User Commands\"\n", version);
  const std::string summary = program.description;
  const std::size_t colon = summary.find(": ");
  out += ".SH NAME\nsurveymc \\- " + roff(colon == std::string::npos ? summary : summary.substr(colon + 2)) + "\n";
  out += ".SH SYNOPSIS\n";
  for (const CommandWords& c : commands) out += synopsis(c) + (&c == &commands.back() ? "" : ".br\n");
  out +=
      ".SH DESCRIPTION\n"
      "Runs experiments from TOML configs: sweeps trajectories, noise levels and error models, estimates sensor "
      "errors\n"
      "on every noisy realisation, predicts the same quantities analytically, and writes comparison tables with a\n"
      "statistical verdict in every row. The same config and seed give the same bits for any number of threads.\n";
  out += ".SH OPTIONS\n";
  for (const OptionWords& o : program.options) out += paragraph(o);
  out += ".SH COMMANDS\n";
  for (const CommandWords& c : commands) {
    out += fmt::format(".SS {}\n{}.\n", roff("surveymc " + c.name), roff(c.description));
    for (const OptionWords& p : c.positionals) out += paragraph(p);
    for (const OptionWords& o : c.options)
      if (o.flags.back() != "--help") out += paragraph(o);
  }
  return out + kRest;
}

}  // namespace surveymc::cli
