#pragma once
/// How many verdicts of each word tables hold.
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "store/table.h"

namespace surveymc::cli {

struct VerdictCounts {
  std::size_t agrees = 0, differs = 0, undecided = 0;
  std::size_t unexpected = 0;  ///< of all rows, those whose verdict is not the one in the column `expected`
  bool judged = false;         ///< there is a column `verdict`
  /// Rows that agree, and that differ, by the margin of their verdict; of tables that show it.
  std::map<double, std::size_t> agrees_within, differs_beyond;
};

VerdictCounts count_verdicts(const std::vector<store::Table>& tables);

/// "3 agree (2 within 3 %, 1 within 6 %), 1 differ (1 beyond 3 %), 0 undecided; 1 not as expected", "" if nothing was
/// judged.
std::string in_words(const VerdictCounts& counts);

}  // namespace surveymc::cli
