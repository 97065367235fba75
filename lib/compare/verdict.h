#pragma once
#include <cstdint>
#include <string>

#include "base/units.h"
#include "stats/confidence_sequence.h"
#include "stats/intervals.h"

namespace surveymc::compare {

/// How comparisons are judged; `[verdict]` of a config.
struct VerdictRule {
  double margin = 0.02;      ///< a ratio within 1 -+ margin counts as equal
  double confidence = 0.95;  ///< of every interval
  /// Margin of a NEES, whose value is a square: sds that are 3 % wrong in all directions, the margin of the studies of
  /// this project, make the NEES 6 % wrong. This margin does not follow `margin`, which a config may widen because it
  /// has few trials: a NEES sums over its dimensions and is known better than any one sd.
  double nees_margin = 0.06;
  /// The run ends when some row is decided: then every interval is that of a confidence sequence, which holds at all
  /// looks at once.
  bool at_all_looks = false;

  /// Confidence of one interval of a value of so many independent units (trials or pairs).
  double interval_confidence(std::uint64_t units) const {
    return at_all_looks && units > 0 ? stats::sequence_confidence(units, confidence) : confidence;
  }
  /// The same rule with another margin.
  VerdictRule with_margin(double other) const {
    VerdictRule rule = *this;
    rule.margin = other;
    return rule;
  }
};

/// What speaks for the verdict of one row, whatever its level: the same standard error that its interval shows, turned
/// into p-values. NaN: the row has no verdict by trials.
struct Evidence {
  /// Of the hypothesis that the value lies within the margin: twice the probability of what was seen, or of more, at
  /// the nearer edge. Below 1 - confidence where the verdict is "differs".
  double p_differs = kNaN;
  /// Of the hypothesis that the value lies outside: twice the larger of the two one-sided p. Below 1 - confidence where
  /// the verdict is "agrees".
  double p_agrees = kNaN;
};
/// `value` with `interval` against 1 -+ margin; on the logarithm, as ratios are, or (means, whose `value` is one plus a
/// shift in sd) as it is. The half of the interval towards an edge gives the standard error. `units`: see
/// interval_confidence().
Evidence evidence_of(double value, const stats::Interval& interval, const VerdictRule& rule, std::uint64_t units,
                     bool logarithmic);

/// ", intervals at 95 %": for the long name of a table with intervals.
std::string at_confidence(double confidence);
/// The same of a rule: ", intervals at all looks at 95 %" where they are those of a sequence.
std::string at_confidence(const VerdictRule& rule);

/// "agrees": the interval lies inside 1 -+ margin (equivalence). "differs": it lies outside altogether.
/// "undecided": neither. "": one of the bounds is not finite.
struct Verdict {
  std::string word;
  std::uint64_t trials_to_decide = 0;  ///< for "undecided": a rough number, as the interval shrinks with its root
};
Verdict judge(const stats::Interval& ratio, double margin, std::uint64_t trials);

}  // namespace surveymc::compare
