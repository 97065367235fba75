#pragma once
#include <cstdint>
#include <string>

#include "stats/intervals.h"

namespace surveymc::study {

/// How comparisons are judged; `[verdict]` of a config.
struct VerdictRule {
  double margin = 0.02;      ///< a ratio within 1 -+ margin counts as equal
  double confidence = 0.95;  ///< of every interval
  /// The same of a NEES, whose value is a square: sds that are 3 % wrong in all directions, the margin of the studies
  /// of this project, make it 6 % wrong. It does not follow `margin`, which a config may widen for want of trials: a
  /// NEES sums over its dimensions and is known better than any one sd.
  double nees_margin = 0.06;
};

/// ", intervals at 95 %": for the long name of a table with intervals.
std::string at_confidence(double confidence);

/// "agrees": the interval lies inside 1 -+ margin (equivalence). "differs": it lies outside altogether.
/// "undecided": neither. "": one of the bounds is not finite.
struct Verdict {
  std::string word;
  std::uint64_t trials_to_decide = 0;  ///< for "undecided": a rough number, as the interval shrinks with its root
};
Verdict judge(const stats::Interval& ratio, double margin, std::uint64_t trials);

}  // namespace surveymc::study
