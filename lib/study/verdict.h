#pragma once
#include <cstdint>
#include <string>

#include "stats/intervals.h"

namespace surveymc {

/// How comparisons are judged; `[verdict]` of a config.
struct VerdictRule {
  double margin = 0.02;      ///< a ratio within 1 -+ margin counts as equal
  double confidence = 0.95;  ///< of every interval
};

/// ", intervals at 95 %": for the long name of a table with intervals.
std::string at_confidence(double confidence);

/// "agrees": the interval lies inside 1 -+ margin (equivalence). "differs": it lies outside altogether.
/// "undecided": neither. "": one of the bounds is not finite.
struct Verdict {
  std::string word;
  std::uint64_t trials_to_decide = 0;  ///< for "undecided": a rough number, as the interval shrinks with its root
};
Verdict judge(const Interval& ratio, double margin, std::uint64_t trials);

}  // namespace surveymc
