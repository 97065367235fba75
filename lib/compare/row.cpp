#include "compare/row.h"

#include "compare/position_comparison.h"

namespace surveymc::compare {

ComparisonRow compare_row(const Row& row, const stats::SampleSummary& found, const VerdictRule& rule,
                          std::uint64_t trials) {
  ComparisonRow compared;
  if (row.statistic == Statistic::mean)
    compared = compare_mean(row.quantity, row.unit, found, row.offset, row.prediction, rule, trials);
  else if (row.statistic == Statistic::squared_distance)
    compared = compare_nees(row.quantity, found, row.prediction, rule, trials);
  else
    compared = compare_sd(row.quantity, row.unit, row.sigmas, found, row.prediction, rule, trials);
  compared.formulation = row.formulation;
  return compared;
}

std::vector<ComparisonRow> compare_rows(const std::vector<Row>& rows, const std::string& table, const VerdictRule& rule,
                                        std::uint64_t trials, const stats::Moments& m) {
  return compare_rows(rows, table, rule, trials, [&](const Row& row) {
    return m.count < 2 ? stats::SampleSummary{} : stats::summarise(m, row.component);
  });
}

}  // namespace surveymc::compare
