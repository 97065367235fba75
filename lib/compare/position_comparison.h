#pragma once
/// Positions of many trials against predicted covariances: error ellipses and mean squared distances with verdicts.
#include <array>
#include <string>

#include <Eigen/Core>

#include "base/units.h"
#include "compare/comparison.h"
#include "compare/table_rows.h"
#include "propagate/ellipse.h"
#include "stats/sample_summary.h"

namespace surveymc::compare {

/// Counts how many points lie in the 1, 2, 3-sigma ellipse, given their squared Mahalanobis distance.
template <class Counts>
void count_inside(double squared_distance, Counts* counts) {
  for (int k = 1; k <= 3; ++k)
    if (squared_distance <= k * k) ++counts[k - 1];
}

/// Monte-Carlo statistics of the horizontal position.
struct HorizontalSample {
  std::uint64_t trials = 0, failed = 0;
  std::uint64_t units = 0;  ///< independent values in the statistics: trials, or antithetic pairs of them
  bool paired = false;
  Eigen::Vector2d mean;        ///< m, N and E
  Eigen::Matrix2d covariance;  ///< m2
};

/// One prediction, and the statistics of the trials with respect to its ellipse.
struct EllipseRow {
  std::string formulation;
  Eigen::Vector2d center;     ///< m, N and E
  Eigen::Matrix2d predicted;  ///< m2
  /// Statistics of the trials along ellipse(predicted).axes, major first. They are tallied along these axes, because
  /// across an arc the kurtosis, and with it the interval, differs much from that in north or east.
  std::array<stats::SampleSummary, 2> along{};
  std::array<std::uint64_t, 3> inside{};
  stats::SampleSummary nees{};                            ///< of the squared Mahalanobis distance
  double wishart_p = 0;                                   ///< NaN where the trials are not normal by construction
  double published_major = kNaN, published_minor = kNaN;  ///< published ratios
  std::string expected = {}, note = {};
};

/// The table `ellipse` (docs/results-format.md), a row at a time; the caller has written the leading columns, if any.
/// Row `monte_carlo`, nothing with fewer than three units.
void write_sample_ellipse(TableRows& t, const HorizontalSample& sample);
/// Row of a prediction: sd and ratio along the *predicted* axes (the sorted axes of a sample ellipse are biased),
/// coverage, NEES, and one verdict for both axes: differs if one differs, agrees if both agree, otherwise undecided. An
/// axis with a predicted sd of 0 has no ratio and no part in the verdict.
void write_ellipse(TableRows& t, const EllipseRow& row, const HorizontalSample& sample, const VerdictRule& rule);

/// Compares the mean squared Mahalanobis distance (NEES) of `dimension` coordinates with its prediction, the dimension.
/// The verdict takes rule.nees_margin.
ComparisonRow compare_nees(const std::string& quantity, const stats::SampleSummary& distance, double dimension,
                           const VerdictRule& rule, std::uint64_t trials);

/// Appends the rows of a table of one depth, with the depth (m) as first column.
void append_at_depth(store::Table& all, store::Table table, double md);

/// Table `realisations`: a row a trial and depth, each `md, trial, north, east, vertical` in `samples` (m).
store::Table position_samples_table(const std::vector<double>& samples);

}  // namespace surveymc::compare
