#include "compare/claims.h"

#include <algorithm>
#include <cmath>

#include "stats/beta_quantile.h"
#include "stats/normal_tail.h"

namespace surveymc::compare {

ComparisonRow mean_row(const std::string& formulation, const std::string& quantity, const std::string& unit,
                       const std::vector<double>& x, double confidence) {
  ComparisonRow row = empty_row(formulation, quantity, unit);
  if (x.empty() || std::isnan(x.front())) return row;
  double mean = 0, squares = 0;
  for (const double v : x) mean += (v - x.front()) / static_cast<double>(x.size());
  mean += x.front();
  for (const double v : x) squares += (v - mean) * (v - mean);
  row.monte_carlo = mean;
  if (squares > 0)
    row.interval =
        stats::student_mean_interval(mean, squares / static_cast<double>(x.size() - 1), x.size(), confidence);
  return row;
}

Evidence claim_evidence(double value, const stats::Interval& interval, double bound, bool below, double confidence,
                        bool logarithmic, double degrees) {
  const auto scaled = [&](double x) { return logarithmic ? std::log(x) : x; };
  const double lo = scaled(interval.lo), hi = scaled(interval.hi), at = scaled(value), edge = scaled(bound);
  if (!std::isfinite(lo) || !std::isfinite(hi) || !std::isfinite(edge)) return {};
  const double half = edge > at ? hi - at : at - lo;
  const bool normal = std::isinf(degrees);
  const double quantile = normal ? stats::normal_quantile((1 + confidence) / 2)
                                 : stats::student_upper_quantile(degrees, (1 - confidence) / 2);
  const double above = edge == at ? 0 : quantile * (at - edge) / half;
  const auto p = [&](double z) {
    if (z <= 0) return 1.0;
    return std::min(1.0, 2 * (normal ? stats::normal_upper_tail(z) : stats::student_upper_tail(degrees, z)));
  };
  return below ? Evidence{p(above), p(-above)} : Evidence{p(-above), p(above)};
}

ComparisonRow judge_claim(ComparisonRow row, double bound, bool below, double confidence, const std::string& note,
                          double degrees) {
  row.note = note;
  if (std::isnan(row.monte_carlo)) return row;
  const stats::Interval i = row.interval;
  if (std::isnan(i.lo)) {
    row.note += "; no interval, no verdict: one realisation, or all alike";
    return row;
  }
  const bool is_below = i.hi<bound, is_above = i.lo> bound;
  row.verdict = !is_below && !is_above ? "undecided" : is_below == below ? "agrees" : "differs";
  row.evidence = claim_evidence(row.monte_carlo, i, bound, below, confidence, false, degrees);
  return row;
}

ComparisonRow judge_mean_claim(const std::string& formulation, const std::string& quantity,
                               const std::vector<double>& x, double bound, bool below, double confidence,
                               const std::string& note) {
  return judge_claim(mean_row(formulation, quantity, "1", x, confidence), bound, below, confidence, note,
                     static_cast<double>(x.size()) - 1);
}

}  // namespace surveymc::compare
