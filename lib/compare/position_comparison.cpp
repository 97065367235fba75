#include "compare/position_comparison.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "stats/antithetic.h"
#include "stats/intervals.h"

namespace surveymc::compare {

namespace {

constexpr stats::Interval kNoInterval{kNaN, kNaN};

/// Everything of a row but the leading columns; `row` is null for the ellipse of the trials themselves.
void write_row(TableRows& t, const std::string& formulation, const Eigen::Vector2d& center, const propagate::Ellipse& e,
               const EllipseRow* row, const HorizontalSample& s, const VerdictRule& rule) {
  t.word("formulation", "monte_carlo, or which analytic prediction", formulation);
  t.number("center_north_m", "m", "centre of the ellipse", center[0]);
  t.number("center_east_m", "m", "centre of the ellipse", center[1]);
  t.number("semi_major_m", "m", "one standard deviation along the major axis", e.semi_major);
  t.number("semi_minor_m", "m", "one standard deviation along the minor axis", e.semi_minor);
  t.number("major_azimuth_deg", "deg", "direction of the major axis, clockwise from north", e.azimuth / kDegree);
  const bool usable = row && s.units > 2;
  const std::array<double, 2> predicted{e.semi_major, e.semi_minor};
  // An axis that is zero to first order has neither ratio nor verdict: trials leave there what is of higher order.
  const std::size_t axes = e.semi_minor > 0 ? 2 : e.semi_major > 0 ? 1 : 0;
  std::array<double, 2> sd{kNaN, kNaN}, ratio = sd;
  std::array<stats::Interval, 2> sd_ci{kNoInterval, kNoInterval}, ratio_ci = sd_ci;
  std::array<Verdict, 2> verdict;
  std::array<Evidence, 2> axis;
  for (std::size_t a = 0; a < 2 && usable; ++a) {
    sd[a] = std::sqrt(row->along[a].variance);
    sd_ci[a] = rule.at_all_looks ? stats::sd_sequence(row->along[a], rule.confidence)
                                 : stats::sd_interval(row->along[a], rule.confidence);
    if (a >= axes) continue;
    ratio[a] = predicted[a] / sd[a];
    ratio_ci[a] = {predicted[a] / sd_ci[a].hi, predicted[a] / sd_ci[a].lo};
    verdict[a] = judge(ratio_ci[a], rule.margin, s.trials);
    axis[a] = evidence_of(ratio[a], ratio_ci[a], rule, s.units, true);
  }
  const std::array<std::string, 2> word{verdict[0].word, verdict[1].word};
  // One axis is enough to differ (Bonferroni), and both have to agree; the major alone, where the minor has no verdict.
  const Evidence both{std::min(1.0, 2 * std::min(axis[0].p_differs, axis[1].p_differs)),
                      std::max(axis[0].p_agrees, axis[1].p_agrees)};
  const Evidence evidence = axes == 2 ? both : axis[0];
  const std::string whole = axes < 2                                       ? word[0]
                            : word[0] == "differs" || word[1] == "differs" ? "differs"
                            : word[0] == word[1]                           ? word[0]
                                                                           : "undecided";
  t.estimate("mc_sd_major_m", "m", "Monte-Carlo standard deviation along this row's major axis", sd[0], sd_ci[0]);
  t.estimate("mc_sd_minor_m", "m", "Monte-Carlo standard deviation along this row's minor axis", sd[1], sd_ci[1]);
  t.estimate("ratio_major", "1", "analytic / Monte Carlo along the major axis", ratio[0], ratio_ci[0]);
  t.estimate("ratio_minor", "1", "analytic / Monte Carlo along the minor axis", ratio[1], ratio_ci[1]);
  const bool has_area = usable && axes == 2;  // a line covers nothing and has no Mahalanobis distance
  for (std::size_t k = 1; k <= 3; ++k) {
    const std::uint64_t inside = has_area ? row->inside[k - 1] : 0;
    t.estimate(fmt::format("coverage_{}sigma", k), "1",
               fmt::format("share of trials inside the {}-sigma ellipse; {:.4f} if normal", k,
                           propagate::ellipse_coverage(static_cast<double>(k))),
               has_area ? static_cast<double>(inside) / static_cast<double>(s.paired ? 2 * s.units : s.units) : kNaN,
               !has_area           ? kNoInterval
               : s.paired          ? stats::paired_binomial_interval(inside, s.units, rule.interval_confidence(s.units))
               : rule.at_all_looks ? stats::rate_sequence(inside, s.units, rule.confidence)
                                   : stats::binomial_interval(inside, s.units, rule.confidence));
  }
  t.estimate("nees", "1", "mean squared Mahalanobis distance from the truth; 2 if consistent",
             has_area ? row->nees.mean : kNaN,
             has_area ? stats::mean_interval(row->nees, rule.interval_confidence(s.units)) : kNoInterval);
  t.number("wishart_p", "1", "p-value of the likelihood-ratio test of the 2x2 covariance",
           has_area ? row->wishart_p : kNaN);
  t.word("wishart_family", "differs: the test says so among all rows of the file (Holm at 5 %); may be chance: not so",
         "");
  t.number("published_ratio_major", "1", "published ratio along the major axis", row ? row->published_major : kNaN);
  t.number("published_ratio_minor", "1", "published ratio along the minor axis", row ? row->published_minor : kNaN);
  t.number("margin", "1", "what agrees: the ratio of both axes within 1 -+ margin",
           word[0].empty() && word[1].empty() ? kNaN : rule.margin);
  t.word("verdict", "both axes agree, one differs, or undecided; by the major axis alone, if the minor has no ratio",
         whole);
  t.word("expected", "the verdict this row should have", row ? row->expected : "");
  const bool judged = !word[0].empty() && (axes < 2 || !word[1].empty());
  write_evidence(t, judged ? evidence : Evidence{},
                 whole == "undecided" ? std::max(verdict[0].trials_to_decide, verdict[1].trials_to_decide) : 0);
  std::string note = row ? row->note : "";
  if (usable && axes < 2)
    note += fmt::format("{}{}zero to first order", note.empty() ? "" : "; ", axes == 1 ? "minor axis: " : "");
  t.word("note", "what else there is to say", note);
  t.count("trials", "trials run", s.trials);
  t.count("failed", "trials without a position, not in the statistics", s.failed);
}

}  // namespace

void write_sample_ellipse(TableRows& t, const HorizontalSample& s) {
  if (s.units < 3) return;
  write_row(t, "monte_carlo", s.mean, propagate::ellipse(s.covariance), nullptr, s, {});
}

void write_ellipse(TableRows& t, const EllipseRow& row, const HorizontalSample& s, const VerdictRule& rule) {
  write_row(t, row.formulation, row.center, propagate::ellipse(row.predicted), &row, s, rule);
}

ComparisonRow compare_nees(const std::string& quantity, const stats::SampleSummary& distance, double dimension,
                           const VerdictRule& rule, std::uint64_t trials) {
  const bool enough = distance.units >= 2;
  const Estimate found =
      enough ? Estimate{distance.mean, stats::mean_interval(distance, rule.interval_confidence(distance.units))}
             : Estimate{};
  ComparisonRow row =
      compare_value(quantity, "1", found, dimension, rule.with_margin(rule.nees_margin), trials, distance.units);
  const stats::Interval band =
      enough ? stats::nees_band(dimension, distance.units, rule.confidence) : stats::Interval{};
  row.note =
      enough ? fmt::format("consistent predictions give {:.3f} .. {:.3f}", band.lo, band.hi) : "fewer than two trials";
  return row;
}

void append_at_depth(store::Table& all, store::Table table, double md) {
  table.columns.insert(table.columns.begin(), {"md_m", "m", "measured depth", std::vector<double>(table.rows(), md)});
  store::append_rows(all, table);
}

store::Table position_samples_table(const std::vector<double>& samples) {
  store::Table t{"realisations", "position errors of the first trials at every reported depth"};
  t.columns = {number_column("md_m", "m", "measured depth"),
               number_column("trial", "1", "number of the trial, from 0")};
  for (const char* direction : {"north_m", "east_m", "vertical_m"})
    t.columns.push_back(number_column(direction, "m", "position less the true one"));
  return table_of_numbers(std::move(t), samples);
}

}  // namespace surveymc::compare
