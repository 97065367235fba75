#include "cli/print_result.h"

#include <algorithm>

#include <fmt/format.h>
#include <unistd.h>

#include "base/shell_word.h"
#include "cli/exit_codes.h"
#include "cli/log.h"
#include "cli/screen.h"
#include "cli/verdict_counts.h"
#include "compare/answer.h"
#include "compare/comparison.h"
#include "compare/warnings.h"
#include "render/json.h"
#include "render/table_text.h"
#include "render/text.h"
#include "study/point_failure.h"

namespace surveymc::cli {
namespace {

/// --quiet closes stdout.
void warn(const std::string& line, bool quiet) { quiet ? log_warning(line) : say(line); }

void print_warning_rows(const store::Table& t, const std::string& path, bool quiet) {
  constexpr std::size_t kMost = 20;
  std::size_t printed = 0, left_out = 0;
  for (const compare::Warning& w : compare::warnings_of(t)) {
    if (quiet && w.severity == "info") continue;
    if (printed < kMost) {
      warn(render::printable(compare::in_words(w)), quiet);
      ++printed;
    } else {
      ++left_out;
    }
  }
  if (left_out > 0)
    warn(fmt::format("and {} more: surveymc show {} {}", counted(left_out, "warning"), shell_word(path), t.name),
         quiet);
}

void print_failed_points(const store::Table& t, bool quiet) {
  const store::Table first = store::rows_of(t, 0, 1);  // a long table waits on the disk
  const auto& reason = std::get<std::vector<std::string>>(first.column("reason").values);
  warn(fmt::format("warning: {} of the sweep could not be run: see {}; the first: {}", counted(t.rows(), "point"),
                   t.name, render::printable(reason.front())),
       quiet);
}

/// Prints tables that are short enough to read; for the others, names the command that prints them.
void print_tables(const store::Result& result, const std::string& path, bool feet) {
  constexpr std::size_t kReadableRows = 30, kReadableColumns = 44, kReadableLines = 100;
  std::string left_out;
  for (const store::Table& t : result.tables) {
    if (t.rows() == 0 || t.name == compare::kWarningsTable || t.name == compare::kAnswerTable) continue;
    const std::string text = t.rows() > kReadableRows || t.columns.size() > kReadableColumns
                                 ? ""
                                 : render::format_table(feet ? in_feet(t) : t, screen_format());
    if (text.empty() || std::count(text.begin(), text.end(), '\n') > std::ptrdiff_t{kReadableLines})
      left_out += (left_out.empty() ? "" : ", ") + t.name;
    else
      fmt::print("{}\n", text);
  }
  if (!left_out.empty())
    say(fmt::format("more tables: {}: surveymc show {} TABLE{}", left_out, shell_word(path),
                    feet ? " --units ft" : ""));
}

/// The table `warnings` of the result at `path`; of many rows the first. `quiet`: on stderr, and without those that
/// only inform.
void print_warnings(const store::Result& result, const std::string& path, bool quiet) {
  for (const store::Table& t : result.tables) {
    if (t.name == study::kFailedPoints) print_failed_points(t, quiet);
    if (t.name == compare::kWarningsTable) print_warning_rows(t, path, quiet);
  }
}

/// Prints how many verdicts there are of each kind; exit code of the run.
int report_verdicts(const store::Result& result, bool check, bool silent) {
  const VerdictCounts counts = count_verdicts(result.tables);
  const std::vector<std::string> unexpected = compare::unexpected_verdicts(result.tables);
  if (!counts.judged) return kDone;  // a study that compares nothing
  if (!silent) {
    say("verdicts: " + in_words(counts));
    for (const std::string& u : unexpected) say("  " + u);
  }
  return check && !unexpected.empty() ? kUnexpected : kDone;
}

}  // namespace

void say(const std::string& line) { fmt::print("{}\n", on_screen(printable_lines(line), STDOUT_FILENO, 4)); }

std::vector<std::string> answer_of(const store::Result& result, bool feet) {
  for (const store::Table& t : result.tables) {
    if (t.name != compare::kAnswerTable) continue;
    auto sentences = std::get<std::vector<std::string>>(t.column("sentence").values);
    for (std::size_t i = 0; feet && i < sentences.size(); ++i)
      sentences[i] = in_feet(sentences[i], t.word("sources", i), result.tables);
    return sentences;
  }
  return {};
}

std::string summary_json(const store::Result& r, const std::string& path) {
  const store::Provenance& p = r.provenance;
  const VerdictCounts v = count_verdicts(r.tables);
  std::string answer;
  for (const std::string& sentence : answer_of(r))
    answer += (answer.empty() ? "" : ", ") + render::json_string(sentence);
  return fmt::format(
      "\"file\": {}, \"title\": {}, \"experiment\": {}, \"seed\": {}, \"trials\": {},\n"
      "\"surveymc_version\": {}, \"git_revision\": {}, \"compiler\": {}, \"command\": {},\n"
      "\"config_hash\": {}, \"content_hash\": {},\n"
      "\"run\": {{\"created\": {}, \"host\": {}, \"elapsed_s\": {}, \"threads\": {}, \"ranks\": {}}},\n"
      "\"verdicts\": {{\"agrees\": {}, \"differs\": {}, \"undecided\": {}, \"unexpected\": {}, "
      "\"findings\": {}}},\n\"answer\": [{}]",
      render::json_string(path), render::json_string(p.title), render::json_string(p.experiment), p.seed, p.trials,
      render::json_string(p.surveymc_version), render::json_string(p.git_revision), render::json_string(p.compiler),
      render::json_string(p.command), render::json_string(p.config_hash),
      render::json_string(store::stored_content_hash(path)), render::json_string(r.run.created),
      render::json_string(r.run.host), render::json_number(r.run.elapsed_s), r.run.threads, r.run.ranks, v.agrees,
      v.differs - v.findings, v.undecided, v.unexpected, v.findings, answer);
}

int print_findings(const RunArguments& a, const store::Result& result, const std::string& path) {
  if (a.json) {
    fmt::print("{{{}", summary_json(result, path));
    for (const store::Table& t : result.tables)
      if (t.name == compare::kWarningsTable) fmt::print(",\n\"warnings\": {}", render::to_json(t));
    fmt::print("}}\n");
    return report_verdicts(result, a.check, true);
  }
  for (const std::string& sentence : answer_of(result, a.units == "ft")) say(sentence);
  if (a.verbose) {
    fmt::print("\n");
    print_tables(result, path, a.units == "ft");
  }
  const int exit = report_verdicts(result, a.check, false);
  if (!a.verbose) say(fmt::format("tables: surveymc show {0}    figures: surveymc plot {0}", shell_word(path)));
  print_warnings(result, path, a.quiet);
  return exit;
}

}  // namespace surveymc::cli
