#include "study/claims.h"

#include <cmath>

namespace surveymc::study {

ComparisonRow mean_row(const std::string& formulation, const std::string& quantity, const std::string& unit,
                       const std::vector<double>& x, double confidence) {
  ComparisonRow row;
  row.formulation = formulation;
  row.quantity = quantity;
  row.unit = unit;
  if (x.empty() || std::isnan(x.front())) return row;
  double mean = 0, squares = 0;
  for (const double v : x) mean += (v - x.front()) / static_cast<double>(x.size());
  mean += x.front();
  for (const double v : x) squares += (v - mean) * (v - mean);
  row.monte_carlo = mean;
  if (x.size() > 1)
    row.interval = stats::mean_interval(mean, squares / static_cast<double>(x.size() - 1), x.size(), confidence);
  return row;
}

ComparisonRow judge_claim(ComparisonRow row, double bound, bool below, const std::string& note) {
  const bool single = std::isnan(row.interval.lo);
  const double lo = single ? row.monte_carlo : row.interval.lo, hi = single ? row.monte_carlo : row.interval.hi;
  if (!std::isnan(row.monte_carlo)) row.verdict = hi < bound ? "agrees" : lo > bound ? "differs" : "undecided";
  if (!below && !row.verdict.empty() && row.verdict != "undecided") row.verdict = lo > bound ? "agrees" : "differs";
  row.note = note + (single && !row.verdict.empty() ? "; one realisation: no interval" : "");
  return row;
}

}  // namespace surveymc::study
