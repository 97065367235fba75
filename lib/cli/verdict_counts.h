#pragma once
/// Numbers of verdicts of each kind in tables.
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "store/table.h"

namespace surveymc::cli {

struct VerdictCounts {
  std::size_t agrees = 0, differs = 0, undecided = 0;
  /// Of those that differ, the ones that may: `expected` says that they are known to be wrong, or that either is fine.
  std::size_t findings = 0;
  /// "Not as expected", here, in `run --check` and in the report alike: rows whose verdict is not the one in the column
  /// `expected`, undecided and missing ones too; and of these the undecided ones.
  std::size_t unexpected = 0, unexpected_undecided = 0;
  bool judged = false;  ///< a row has a verdict, or should have one
  /// Rows that agree, and that differ, by the margin of their verdict; of tables that show it.
  std::map<double, std::size_t> agrees_within, differs_beyond;
};

VerdictCounts count_verdicts(const std::vector<store::Table>& tables);

/// "3 agree (2 within 3 %, 1 within 6 %), 1 finding, 1 differs (2 beyond 3 %), 4 undecided; 1 not as expected"; what
/// there is none of is left out; "; all as expected" where nothing differs that may not. "" if nothing was judged.
std::string in_words(const VerdictCounts& counts);

}  // namespace surveymc::cli
