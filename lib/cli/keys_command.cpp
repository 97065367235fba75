#include "cli/commands.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "cli/exit_codes.h"
#include "cli/file_kind.h"
#include "cli/screen.h"
#include "config/suggest.h"
#include "render/text.h"
#include "sweep/config_keys.h"
#include "sweep/config_schema.h"

namespace surveymc::cli {
namespace {

/// A line with the key, and below it what it means, then its type, default, rule and an example; no line is longer than
/// `width`, but for a word that is.
std::string as_text(const store::Table& table, std::size_t width) {
  std::string out;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto word = [&](const char* column) { return table.word(column, row); };
    std::string text = word("type");
    if (const std::string unit = word("unit"); !unit.empty()) text += ", " + unit;
    const std::string usual = word("default");
    const bool is_needed = usual == "must be given" || usual.starts_with("needed");
    if (!usual.empty() && usual != "-") text += is_needed ? "; " + usual : "; default " + usual;
    if (const std::string rule = word("rule"); !rule.empty()) text += "; " + rule;
    if (const std::string example = word("example"); !example.empty()) text += "; such as " + example;
    out += word("key") + "\n";
    for (const std::string& below : {word("meaning"), text}) out += render::folded("    " + below, width, 6) + "\n";
  }
  return out;
}

/// "after Hanak 2016"; what goes on from its source says so itself: "beyond Nyrnes et al."
std::string after(const std::string& source) { return source.starts_with("beyond ") ? source : "after " + source; }

}  // namespace

const study::Experiment& experiment_named(const std::vector<study::Experiment>& studies, const std::string& name,
                                          const std::string& command) {
  std::vector<std::string> known;
  for (const study::Experiment& e : studies) {
    if (e.name() == name) return e;
    known.push_back(e.name());
  }
  if (const std::string own = experiment_of_config(name); !own.empty())
    throw UsageError(
        fmt::format("{0} {1}: must be the name of an experiment, but this is a config of one:\n  surveymc {0} {2}",
                    command, render::printable(name), render::printable(own)));
  const std::string near = config::nearest(name, known);
  throw UsageError(fmt::format(
      "{} {}: no experiment has this name: {}", command, render::printable(name),
      near.empty() ? fmt::format("there are {}", fmt::join(known, ", ")) : fmt::format("did you mean {}?", near)));
}

std::string list_text(const std::vector<study::Experiment>& studies) {
  std::string out;
  for (const study::Experiment& e : studies)
    for (const std::string& text :
         {fmt::format("{:<24} {}", e.name(), e.summary), fmt::format("{:<24}   {}", "", after(e.reproduces))})
      out += on_screen(text, STDOUT_FILENO, 27) + '\n';
  return out;
}

void print_keys(const std::vector<study::Experiment>& studies, const KeysArguments& a) {
  if (a.experiment.empty()) return fmt::print("{}", list_text(studies));
  const store::Table table = sweep::config_keys(experiment_named(studies, a.experiment, "keys"));
  if (a.csv) return print_csv(table);
  constexpr std::size_t kReadable = 100;  // letters of a line
  const std::size_t screen = screen_width(STDOUT_FILENO);
  print_lines(as_text(table, screen == 0 ? kReadable : std::min(screen, kReadable)));
}

void print_schema(const std::vector<study::Experiment>& studies, const std::string& experiment) {
  fmt::print("{}", sweep::config_schema(experiment_named(studies, experiment, "schema")));
}

}  // namespace surveymc::cli
