#include "cli/verdict_counts.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "compare/comparison.h"

namespace surveymc::cli {

namespace {

void add_verdicts(const store::Table& t, VerdictCounts& counts) {
  const store::Column *margins = t.find_column("margin"), *wishes = t.find_column("expected");
  const auto* margin = margins ? std::get_if<std::vector<double>>(&margins->values) : nullptr;
  const auto* expected = wishes ? std::get_if<std::vector<std::string>>(&wishes->values) : nullptr;
  for (const store::Column& c : t.columns) {
    if (c.name != "verdict") continue;
    const auto& words = std::get<std::vector<std::string>>(c.values);
    const auto number_of = [&](const char* word) {
      return static_cast<std::size_t>(std::count(words.begin(), words.end(), word));
    };
    const auto is_said = [](const std::string& word) { return !word.empty(); };
    counts.judged = counts.judged || std::any_of(words.begin(), words.end(), is_said) ||
                    (expected && std::any_of(expected->begin(), expected->end(), is_said));
    counts.agrees += number_of("agrees");
    counts.differs += number_of("differs");
    counts.undecided += number_of("undecided");
    for (std::size_t i = 0; expected && i < words.size(); ++i) {
      const std::string& wanted = (*expected)[i];
      counts.findings += words[i] == "differs" && (wanted == "differs" || wanted == store::kEither);
      counts.unexpected_undecided +=
          !wanted.empty() && wanted != store::kEither && words[i] == "undecided" && words[i] != wanted;
    }
    for (std::size_t i = 0; margin && i < words.size(); ++i) {
      if (std::isnan((*margin)[i])) continue;
      if (words[i] == "agrees") ++counts.agrees_within[(*margin)[i]];
      if (words[i] == "differs") ++counts.differs_beyond[(*margin)[i]];
    }
  }
}

}  // namespace

VerdictCounts count_verdicts(const std::vector<store::Table>& tables) {
  VerdictCounts counts;
  for (const store::Table& t : tables)
    if (t.find_column("verdict"))
      store::for_each_piece(t, [&](const store::Table& piece, std::size_t) { add_verdicts(piece, counts); });
  counts.unexpected = compare::unexpected_verdicts(tables).size();
  return counts;
}

namespace {

/// " (2 within 3 %, 1 within 6 %)"; "" if there are none.
std::string by_margin(const std::map<double, std::size_t>& counts, const char* word) {
  std::string out;
  for (const auto& [margin, n] : counts)
    out += fmt::format("{}{} {} {:.3g} %", out.empty() ? " (" : ", ", n, word, 100 * margin);
  return out.empty() ? out : out + ")";
}

}  // namespace

std::string in_words(const VerdictCounts& counts) {
  if (!counts.judged) return "";
  std::string out;
  const auto add = [&](std::size_t n, const char* one, const char* several, const std::string& margins = "") {
    if (n > 0) out += fmt::format("{}{} {}{}", out.empty() ? "" : ", ", n, n == 1 ? one : several, margins);
  };
  const std::string beyond = by_margin(counts.differs_beyond, "beyond");
  const std::size_t differs = counts.differs - counts.findings, open = counts.unexpected_undecided;
  add(counts.agrees, "agrees", "agree", by_margin(counts.agrees_within, "within"));
  add(counts.findings, "finding", "findings", differs == 0 ? beyond : "");
  add(differs, "differs", "differ", beyond);
  add(counts.undecided, "undecided", "undecided");
  if (out.empty()) out = "no verdict";
  if (counts.unexpected == 0) return differs == 0 ? out + "; all as expected" : out;
  return out + fmt::format("; {} not as expected{}", counts.unexpected,
                           open == 0                   ? ""
                           : open == counts.unexpected ? " (undecided)"
                                                       : fmt::format(" ({} of them undecided)", open));
}

}  // namespace surveymc::cli
