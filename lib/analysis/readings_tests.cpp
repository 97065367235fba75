#include "analysis/readings_tests.h"

#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "stats/intervals.h"

namespace surveymc::analysis {
namespace {

/// Chi-squared, both tails: residuals may be too large or too small for the claimed noise.
ReadingsTest variance_factor_test(const estimate::ResidualTests& t, double alpha) {
  ReadingsTest row{.test = "variance_factor", .statistic = t.variance_factor()};
  if (t.redundancy == 0) {
    row.decision = "not tested";
    row.note = "as many residuals as unknowns: nothing is left to test";
    return row;
  }
  const double r = t.redundancy, upper = stats::chi_squared_upper_tail(r, t.statistic);
  row.critical_low = stats::chi_squared_quantile(r, alpha / 2) / r;
  row.critical_high = stats::chi_squared_quantile(r, 1 - alpha / 2) / r;
  row.p_value = std::min(1.0, 2 * std::min(upper, 1 - upper));
  const bool large = row.statistic > row.critical_high, small = row.statistic < row.critical_low;
  row.decision = large || small ? "rejected" : "accepted";
  row.note = fmt::format("chi-squared {:.4g} with {} degrees of freedom; residuals are {:.3g} times what the noise {}",
                         t.statistic, t.redundancy, std::sqrt(row.statistic),
                         large   ? "allows: a gross error, a wrong reference, or more noise"
                         : small ? "would make: less noise than claimed"
                                 : "would make");
  return row;
}

ReadingsTest perfect_tool_test(double statistic, double alpha) {
  ReadingsTest row{.test = "perfect_tool", .statistic = statistic};
  row.critical_high = stats::chi_squared_quantile(6, 1 - alpha);
  row.p_value = stats::chi_squared_upper_tail(6, statistic);
  row.decision = statistic > row.critical_high ? "rejected" : "accepted";
  row.note = row.decision == "rejected" ? "gains and biases differ from 1 and 0 by more than their uncertainty"
                                        : "no gain or bias differs from 1 or 0 by more than its uncertainty";
  return row;
}

}  // namespace

std::vector<ReadingsTest> judge_readings(const survey::SixAxisReadings& readings, const ReadingsAnalysis& a,
                                         const TestLevels& levels) {
  std::vector<ReadingsTest> rows{variance_factor_test(a.tests, levels.alpha),
                                 perfect_tool_test(a.perfect_tool_statistic, levels.alpha)};
  const double critical = stats::normal_quantile(1 - levels.alpha_w / 2);
  for (std::size_t k = 0; k < a.stations.size(); ++k)
    for (int c = 0; c < 2; ++c) {
      const double w = a.tests.w[k][c];
      ReadingsTest row{"residual",
                       static_cast<std::int64_t>(k),
                       readings.md[k],
                       c == 0 ? "horizontal" : "vertical",
                       w,
                       -critical,
                       critical,
                       stats::chi_squared_upper_tail(1, w * w),
                       a.tests.error[k][c],
                       a.tests.error_sd[k][c],
                       std::abs(w) > critical ? "rejected" : "accepted",
                       ""};
      if (std::isnan(w)) {
        row.p_value = kNaN;
        row.decision = "not tested";
        row.note = "no other reading checks this one";
      }
      rows.push_back(row);
    }
  const int s = suspect(rows);
  for (std::size_t i = 0; i < rows.size() && s >= 0; ++i)
    if (rows[i].test == "residual" && rows[i].decision == "rejected")
      rows[i].note = static_cast<int>(i) == s
                         ? "suspect: the largest of all; see tables suspect_readings and without_suspect"
                         : "may follow from the suspect";
  return rows;
}

int suspect(const std::vector<ReadingsTest>& tests) {
  int found = -1;
  for (std::size_t i = 0; i < tests.size(); ++i)
    if (tests[i].test == "residual" && tests[i].decision == "rejected" &&
        (found < 0 || std::abs(tests[i].statistic) > std::abs(tests[static_cast<std::size_t>(found)].statistic)))
      found = static_cast<int>(i);
  return found;
}

}  // namespace surveymc::analysis
