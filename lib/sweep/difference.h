#pragma once
/// Comparison of two results of one experiment: which of their values differ beyond chance.
#include <string>
#include <vector>

#include "base/units.h"
#include "store/result_file.h"

namespace surveymc::sweep {

struct DifferenceRule {
  double level = 0.05;         ///< family-wise, over all rows that chance can move (Holm 1979)
  double tolerance = 0;        ///< for the same draws: smaller changes, in standard errors, do not count
  double analytic = 1e-12;     ///< smaller relative differences of a prediction do not count
  std::uint64_t least = 1000;  ///< trials, and
  std::uint64_t hits = 5;      ///< events in both together, below which nothing is said
};

/// One value that stands in both results, or in one of them.
struct DifferenceRow {
  std::string table, row, column;  ///< `row`: what names it, "noise.scale = 1 sigma3_north"
  double a = kNaN, b = kNaN;
  /// ln(b / a) of positive values with an uneven interval (sds, ratios, probabilities); b - a of means; of predictions
  /// b / a - 1.
  double difference = kNaN;
  double standard_error = kNaN;  ///< of `difference`; NaN of predictions
  double p = kNaN;               ///< two-sided, of one row; NaN where chance has no part
  /// Smallest |difference| that is found beside all other rows with probability 0.9.
  double detectable = kNaN;
  /// "equal": the same bits. "chance": no difference beyond chance. "differs": beyond chance. "changed": the same
  /// draws, or no draws, and another value. "few": too few trials or events. "only in A", "only in B". "other unit",
  /// "other margin": cannot be compared. "verdict": only the verdict is another one; what it was and is stands in
  /// `note`.
  std::string finding, note;

  bool counts() const { return finding != "equal" && finding != "chance" && finding != "few" && finding != "verdict"; }
};

struct Differences {
  std::vector<DifferenceRow> rows;
  bool same_seed = false, same_trials = false;
  std::size_t judged = 0;  ///< rows that chance can move

  bool any() const;
};

/// Rows are matched by table and by what names them: the sweep's keys and words such as quantity and formulation; of
/// rows with the same names the first with the first. Statistics:
///  * other seeds: z = (b - a) / sqrt(se_a^2 + se_b^2), each standard error from the half of its interval towards the
///    other value; the counts of a rate by the exact conditional test (Fisher);
///  * the same seed: the draws are common. What differs has changed; with other trials, one run holds the other,
///    and the variance is se_b^2 - se_a^2;
///  * predictions: any relative difference above rule.analytic.
/// Intervals of a confidence sequence ([stop] verdict) are wider than those of as many trials; taken as if they were
/// not, they make standard errors too large and false alarms rarer, also where the moment of the stop depends on the
/// value. The looks of a stopping rule and the numbers of failed trials are not compared across draws.
/// Columns that are neither Monte-Carlo values with an interval nor predictions are compared where no chance is: for
/// the same draws, or without any. Maps likewise. Samples are not compared. Throws InputError if the results are of
/// different experiments.
Differences compare_results(const store::Result& a, const store::Result& b, const DifferenceRule& rule);

/// A key of the config, or the rows of an input, that two results have not alike; "" where one of them has it not.
struct KeyDifference {
  std::string key, a, b;
};

/// Sorted by key; values are TOML. Defaults count as if they were written.
std::vector<KeyDifference> differing_keys(const store::Result& a, const store::Result& b);

/// Fisher's exact test, two-sided by small probabilities: k1 events of n1 trials and k2 of n2 have the same rate.
double same_rate_p(std::uint64_t k1, std::uint64_t n1, std::uint64_t k2, std::uint64_t n2);

/// The rows as a table. `all`: those without a difference, too.
store::Table difference_table(const Differences& differences, bool all);

}  // namespace surveymc::sweep
