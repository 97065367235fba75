#pragma once
/// Comparison tables: Monte Carlo, analytic and published values of one quantity in a row, with a verdict.
#include <optional>
#include <string>
#include <vector>

#include "base/units.h"
#include "compare/table_rows.h"
#include "compare/verdict.h"
#include "stats/histogram.h"
#include "stats/sample_summary.h"
#include "store/table.h"

namespace surveymc::compare {

/// One row. `ratio` is analytic / monte_carlo, `published_ratio` published / monte_carlo. NaN: not there.
struct ComparisonRow {
  std::string formulation = {};  ///< which prediction; "" where a table has only one
  std::string quantity = {}, unit = {};
  double monte_carlo = kNaN;
  stats::Interval interval{monte_carlo, monte_carlo};
  double analytic = kNaN;
  double ratio = kNaN;
  stats::Interval ratio_interval{ratio, ratio};
  double published = kNaN;
  std::string verdict = {}, expected = {}, note = {};
  double margin = kNaN;  ///< margin of the verdict
  /// What the verdict is on: the ratio, or one plus the shift of a mean in sd.
  double judged = kNaN;
  stats::Interval judged_interval{judged, judged};
  Evidence evidence = {};
  std::uint64_t trials_to_decide = 0;        ///< of an undecided row
  std::optional<std::uint64_t> failed = {};  ///< where rows of a table leave out different trials
};

/// A row that has nothing but its names.
ComparisonRow empty_row(const std::string& formulation, const std::string& quantity, const std::string& unit);

/// A Monte-Carlo value and its interval. NaN: not there.
struct Estimate {
  double value = kNaN;
  stats::Interval interval{value, value};
};
/// Mean of component `index`, and the root of this mean, which is an RMS if the component is a square; NaN with fewer
/// than two values.
Estimate mean_estimate(const stats::Moments& moments, Eigen::Index index, double confidence);
Estimate rms_estimate(const stats::Moments& squares, Eigen::Index index, double confidence);
/// The same from a mean of `count` squares and their variance.
Estimate rms_estimate(double mean_square, double variance, std::uint64_t count, double confidence);

/// Compares a positive value with its prediction, by the ratio of the two. Without a finite prediction, or if the value
/// is 0, there is neither ratio nor verdict. `units`: independent units behind `found`; 0: as many as trials.
ComparisonRow compare_value(const std::string& quantity, const std::string& unit, const Estimate& found,
                            double predicted, const VerdictRule& rule, std::uint64_t trials, std::uint64_t units = 0);

/// Standard deviation of component `index`, times `sigmas`, against a predicted one (not yet multiplied).
/// Skewness and kurtosis go to the note where the distribution is clearly not normal.
ComparisonRow compare_sd(const std::string& quantity, const std::string& unit, double sigmas,
                         const stats::Moments& moments, Eigen::Index index, double predicted_sd,
                         const VerdictRule& rule, std::uint64_t trials);
ComparisonRow compare_sd(const std::string& quantity, const std::string& unit, double sigmas,
                         const stats::SampleSummary& sample, double predicted_sd, const VerdictRule& rule,
                         std::uint64_t trials);

/// Compares the mean of component `index` plus `offset` with `predicted`. A ratio of two values near zero says nothing,
/// so means have no ratio: the verdict is on the shift from the prediction in units of the Monte-Carlo sd, with the
/// same margin.
ComparisonRow compare_mean(const std::string& quantity, const std::string& unit, const stats::Moments& moments,
                           Eigen::Index index, double offset, double predicted, const VerdictRule& rule,
                           std::uint64_t trials);
ComparisonRow compare_mean(const std::string& quantity, const std::string& unit, const stats::SampleSummary& sample,
                           double offset, double predicted, const VerdictRule& rule, std::uint64_t trials);

/// Removes the verdict of a row and what belongs to it: margin, p-values, trials that would decide. `why` becomes its
/// note.
void leave_unjudged(ComparisonRow& row, const std::string& why);

/// If more than the share `most` of the trials failed, the others are no sample of all. Then each row with a verdict or
/// a finite prediction becomes "undecided", and its note begins with the reason. `what` names what failed:
/// "adjustments"; `did`: what became of them.
void leave_undecided(std::vector<ComparisonRow>& rows, std::uint64_t failed, std::uint64_t trials, double most,
                     const std::string& what, const std::string& did = "did not converge");

/// Rate of an event seen `events` times in `runs` against a predicted probability; NaN: there is none. It stands in the
/// table within [0, 1], whatever its rounding. A prediction of 0 has no ratio: it agrees where the whole interval lies
/// within the margin of 0, and differs once the event is seen. Intervals and p-values are exact (Clopper and Pearson;
/// at all looks those of the beta-binomial mixture).
ComparisonRow compare_rate(const std::string& quantity, std::uint64_t events, std::uint64_t runs, double predicted,
                           const VerdictRule& rule, std::uint64_t trials);

/// Quantile of the values behind the counts of a histogram, by order statistics: interval and p-values are exact,
/// whatever the distribution, but for the width of a bin.
ComparisonRow compare_quantile(const std::string& quantity, const std::string& unit, const stats::HistogramBins& bins,
                               const std::uint64_t* counts, double probability, double predicted,
                               const VerdictRule& rule, std::uint64_t trials);

/// The row with this formulation.
ComparisonRow labelled(const std::string& formulation, ComparisonRow row);

/// The columns behind a verdict: p_differs, p_agrees, family (empty: apply_family() fills it) and trials_to_decide.
void write_evidence(TableRows& t, const Evidence& evidence, std::uint64_t trials_to_decide);

/// The columns of every comparison table (docs/results-format.md) from rows. `trials` and, but for rows that have their
/// own, `failed` are repeated. The column `formulation` is there if a row has one, or if it is asked for: tables of one
/// study must be alike.
store::Table comparison_table(const std::string& name, const std::string& long_name,
                              const std::vector<ComparisonRow>& rows, std::uint64_t trials, std::uint64_t failed,
                              bool with_formulation = false);

/// How well a reading of a source reproduces its published standard deviations: one row for all rows that have a
/// published value and a ratio. Columns `quantities` (how many), `rms_log_ratio` (root mean square of
/// ln(published / Monte Carlo)), `ratio_min`, `ratio_max`.
store::Table published_fit_table(const std::vector<ComparisonRow>& rows);

/// Rows whose verdict is not the expected one, as text for a terminal; empty if there are none. Looks at every table
/// that has the columns `verdict` and `expected`. A row that differs and "may be chance" in its family does not count.
std::vector<std::string> unexpected_verdicts(const std::vector<store::Table>& tables);

}  // namespace surveymc::compare
