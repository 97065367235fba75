#pragma once
/// What a study declares of the rows of its comparison tables, once: its list rows_of(scenario). What a config may name
/// ([[published]], [[expect]], [stop], [calibration]) and what the tables show follow from that list.
#include <string>

#include "base/units.h"
#include "compare/comparison.h"

namespace surveymc::compare {

/// Which statistic of the tallied numbers a row compares with its prediction.
enum class Statistic {
  mean,
  sd,
  squared_distance,  ///< the mean of a squared Mahalanobis distance: NEES
  angle,             ///< an angle, by its tangent
  other              ///< what the study's own code compares
};

struct Row {
  std::string table = {}, formulation = {}, quantity = {}, unit = {};
  Statistic statistic = Statistic::other;
  int component = -1;        ///< where the study tallies it
  double offset = 0;         ///< what is added to a mean
  double sigmas = 1;         ///< how many standard deviations an sd is shown as
  double prediction = kNaN;  ///< of the statistic; NaN before the point is prepared, or where there is none
  int variance = -1;         ///< component whose mean is the predicted variance, in place of `prediction`; -1: none
  bool predicted = true;     ///< it has a margin, and an interval that may hold at all looks: trials can decide it
  bool controlled = false;   ///< [stop] may ask for its precision
  bool calibrated = false;   ///< a row of the table calibration: its claimed distribution is judged
  bool available = true;     ///< this scenario has it; a config may name the rows of all points of its sweep
};

/// The statistic of `found`, what was tallied of the row's component, against its prediction.
ComparisonRow compare_row(const Row& row, const stats::SampleSummary& found, const VerdictRule& rule,
                          std::uint64_t trials);

/// The rows of `table` that the scenario has, each as compare_row() of what `sample(row)` found.
template <class Sample>
std::vector<ComparisonRow> compare_rows(const std::vector<Row>& rows, const std::string& table, const VerdictRule& rule,
                                        std::uint64_t trials, const Sample& sample) {
  std::vector<ComparisonRow> out;
  for (const Row& row : rows)
    if (row.table == table && row.available && !row.calibrated)
      out.push_back(compare_row(row, sample(row), rule, trials));
  return out;
}
/// The same of moments whose columns are the components.
std::vector<ComparisonRow> compare_rows(const std::vector<Row>& rows, const std::string& table, const VerdictRule& rule,
                                        std::uint64_t trials, const stats::Moments& moments);

}  // namespace surveymc::compare
