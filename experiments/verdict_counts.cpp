#include "verdict_counts.h"

#include <algorithm>

#include <fmt/format.h>

#include "study/comparison.h"

namespace surveymc {

VerdictCounts count_verdicts(const std::vector<Table>& tables) {
  VerdictCounts counts;
  for (const Table& t : tables) {
    for (const Column& c : t.columns) {
      if (c.name != "verdict") continue;
      const auto& words = std::get<std::vector<std::string>>(c.values);
      const auto number_of = [&](const char* word) {
        return static_cast<std::size_t>(std::count(words.begin(), words.end(), word));
      };
      counts.judged = true;
      counts.agrees += number_of("agrees");
      counts.differs += number_of("differs");
      counts.undecided += number_of("undecided");
    }
  }
  counts.unexpected = unexpected_verdicts(tables).size();
  return counts;
}

std::string in_words(const VerdictCounts& counts) {
  if (!counts.judged) return "";
  return fmt::format("{} agree, {} differ, {} undecided; {} not as expected", counts.agrees, counts.differs,
                     counts.undecided, counts.unexpected);
}

}  // namespace surveymc
