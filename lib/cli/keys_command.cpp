#include "cli/commands.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "cli/exit_codes.h"
#include "cli/file_kind.h"
#include "cli/screen.h"
#include "config/suggest.h"
#include "sweep/config_keys.h"

namespace surveymc::cli {
namespace {

using Row = std::array<std::string, 6>;  // key, type, unit, default, rule, example

std::vector<Row> rows_of(const store::Table& table) {
  std::vector<Row> rows{{"key", "type", "unit", "default", "rule", "example"}};
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Row row;
    for (std::size_t c = 0; c < row.size(); ++c) {
      row[c] = std::get<std::vector<std::string>>(table.columns[c].values)[i];
      if (row[c].empty()) row[c] = "-";
    }
    rows.push_back(row);
  }
  return rows;
}

/// One line a key; `width` letters for each column but the last two, whose text may be long.
std::string as_lines(const std::vector<Row>& rows) {
  std::array<std::size_t, 6> width{};
  for (const Row& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  constexpr std::size_t kRule = 4, kMostRule = 60;
  width[kRule] = std::min(width[kRule], kMostRule);
  std::string out;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) line += fmt::format("{:<{}}  ", row[c], width[c]);
    out += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return out;
}

/// Some lines a key, for a narrow screen.
std::string as_blocks(const std::vector<Row>& rows, std::size_t width) {
  std::string out;
  for (auto row = rows.begin() + 1; row != rows.end(); ++row) {
    const auto& [key, type, unit, usual, rule, example] = *row;
    out += key + "\n";
    std::string text = type;
    if (unit != "-") text += ", " + unit;
    const bool is_needed = usual == "must be given" || usual.starts_with("needed");
    text += usual == "-" ? "" : is_needed ? "; " + usual : "; default " + usual;
    if (rule != "-") text += "; " + rule;
    if (example != "-") text += "; such as " + example;
    out += store::folded("    " + text, std::max<std::size_t>(width, 24), 4) + "\n";
  }
  return out;
}

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
                    command, store::printable(name), store::printable(own)));
  const std::string near = config::nearest(name, known);
  throw UsageError(fmt::format(
      "{} {}: no experiment has this name: {}", command, store::printable(name),
      near.empty() ? fmt::format("there are {}", fmt::join(known, ", ")) : fmt::format("did you mean {}?", near)));
}

std::string list_text(const std::vector<study::Experiment>& studies) {
  std::string out;
  for (const study::Experiment& e : studies)
    for (const std::string& text :
         {fmt::format("{:<24} {}", e.name(), e.summary), fmt::format("{:<24}   after {}", "", e.reproduces)})
      out += on_screen(text, STDOUT_FILENO, 27) + '\n';
  return out;
}

void print_keys(const std::vector<study::Experiment>& studies, const KeysArguments& a) {
  if (a.experiment.empty()) return fmt::print("{}", list_text(studies));
  const store::Table table = sweep::config_keys(experiment_named(studies, a.experiment, "keys"));
  if (a.csv) return print_csv(table);
  const std::vector<Row> rows = rows_of(table);
  const std::size_t width = screen_width(STDOUT_FILENO);
  const std::string lines = as_lines(rows);
  print_lines(width == 0 || store::longest_line(lines) <= width ? lines : as_blocks(rows, width));
}

}  // namespace surveymc::cli
