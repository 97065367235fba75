#include "cli/verdict_counts.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/comparison.h"

namespace surveymc::cli {

VerdictCounts count_verdicts(const std::vector<store::Table>& tables) {
  VerdictCounts counts;
  for (const store::Table& t : tables) {
    const std::vector<double>* margin = nullptr;
    for (const store::Column& c : t.columns)
      if (c.name == "margin") margin = std::get_if<std::vector<double>>(&c.values);
    for (const store::Column& c : t.columns) {
      if (c.name != "verdict") continue;
      const auto& words = std::get<std::vector<std::string>>(c.values);
      const auto number_of = [&](const char* word) {
        return static_cast<std::size_t>(std::count(words.begin(), words.end(), word));
      };
      counts.judged = true;
      counts.agrees += number_of("agrees");
      counts.differs += number_of("differs");
      counts.undecided += number_of("undecided");
      for (std::size_t i = 0; margin && i < words.size(); ++i) {
        if (std::isnan((*margin)[i])) continue;
        if (words[i] == "agrees") ++counts.agrees_within[(*margin)[i]];
        if (words[i] == "differs") ++counts.differs_beyond[(*margin)[i]];
      }
    }
  }
  counts.unexpected = study::unexpected_verdicts(tables).size();
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
  return fmt::format("{} agree{}, {} differ{}, {} undecided; {} not as expected", counts.agrees,
                     by_margin(counts.agrees_within, "within"), counts.differs,
                     by_margin(counts.differs_beyond, "beyond"), counts.undecided, counts.unexpected);
}

}  // namespace surveymc::cli
