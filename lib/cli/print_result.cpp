#include "cli/print_result.h"

#include <algorithm>

#include <fmt/format.h>
#include <unistd.h>

#include "base/shell_word.h"
#include "cli/exit_codes.h"
#include "cli/log.h"
#include "cli/screen.h"
#include "cli/verdict_counts.h"
#include "compare/comparison.h"
#include "study/point_failure.h"

namespace surveymc::cli {
namespace {

constexpr const char* kWarningsTable = "warnings";

/// --quiet closes stdout.
void warn(const std::string& line, bool quiet) { quiet ? log_warning(line) : say(line); }

void print_warning_rows(const store::Table& t, bool quiet) {
  const auto& severity = std::get<std::vector<std::string>>(t.column("severity").values);
  const auto& message = std::get<std::vector<std::string>>(t.column("message").values);
  for (std::size_t row = 0; row < t.rows(); ++row) {
    if (quiet && severity[row] == "info") continue;
    std::string point;  // columns of the sweep stand in front
    for (const store::Column& c : t.columns) {
      if (c.name == "severity") break;
      if (const auto* words = std::get_if<std::vector<std::string>>(&c.values))
        point += store::printable((*words)[row]) + ": ";
      else
        point += fmt::format("{} = {:g}: ", c.name, std::get<std::vector<double>>(c.values)[row]);
    }
    warn(fmt::format("{}: {}{}", severity[row], point, store::printable(message[row])), quiet);
  }
}

void print_failed_points(const store::Table& t, bool quiet) {
  const store::Table first = store::rows_of(t, 0, 1);  // a long table waits on the disk
  const auto& reason = std::get<std::vector<std::string>>(first.column("reason").values);
  warn(fmt::format("warning: {} of the sweep could not be run: see {}; the first: {}", counted(t.rows(), "point"),
                   t.name, store::printable(reason.front())),
       quiet);
}

}  // namespace

void say(const std::string& line) { fmt::print("{}\n", on_screen(printable_lines(line), STDOUT_FILENO, 4)); }

void print_tables(const store::Result& result, const std::string& path, bool feet) {
  constexpr std::size_t kReadableRows = 30, kReadableColumns = 44, kReadableLines = 100;
  std::string left_out;
  for (const store::Table& t : result.tables) {
    if (t.rows() == 0 || t.name == kWarningsTable) continue;
    const std::string text = t.rows() > kReadableRows || t.columns.size() > kReadableColumns
                                 ? ""
                                 : store::format_table(feet ? in_feet(t) : t, screen_format());
    if (text.empty() || std::count(text.begin(), text.end(), '\n') > std::ptrdiff_t{kReadableLines})
      left_out += (left_out.empty() ? "" : ", ") + t.name;
    else
      fmt::print("{}\n", text);
  }
  if (!left_out.empty())
    say(fmt::format("more tables: {}: surveymc show {} TABLE{}", left_out, shell_word(path),
                    feet ? " --units ft" : ""));
}

void print_warnings(const store::Result& result, bool quiet) {
  for (const store::Table& t : result.tables) {
    if (t.name == study::kFailedPoints) print_failed_points(t, quiet);
    if (t.name != kWarningsTable) continue;
    store::for_each_piece(t, [&](const store::Table& piece, std::size_t) { print_warning_rows(piece, quiet); });
  }
}

int report_verdicts(const store::Result& result, bool check) {
  const VerdictCounts counts = count_verdicts(result.tables);
  const std::vector<std::string> unexpected = compare::unexpected_verdicts(result.tables);
  if (!counts.judged) return kDone;  // a study that compares nothing
  say("verdicts: " + in_words(counts));
  for (const std::string& u : unexpected) say("  " + u);
  return check && !unexpected.empty() ? kUnexpected : kDone;
}

}  // namespace surveymc::cli
