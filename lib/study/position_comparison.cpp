#include "study/position_comparison.h"

#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "stats/antithetic.h"
#include "stats/intervals.h"

namespace surveymc {

Table ellipse_columns(const std::string& long_name, std::vector<Column> leading) {
  Table t{"ellipse", long_name, std::move(leading)};
  t.columns.push_back(word_column("formulation", "monte_carlo, or which analytic prediction"));
  t.columns.push_back(number_column("center_north_m", "m", "centre of the ellipse"));
  t.columns.push_back(number_column("center_east_m", "m", "centre of the ellipse"));
  t.columns.push_back(number_column("semi_major_m", "m", "one standard deviation along the major axis"));
  t.columns.push_back(number_column("semi_minor_m", "m", "one standard deviation along the minor axis"));
  t.columns.push_back(number_column("major_azimuth_deg", "deg", "direction of the major axis, clockwise from north"));
  add_with_interval(t, "mc_sd_major_m", "m", "Monte-Carlo standard deviation along this row's major axis");
  add_with_interval(t, "mc_sd_minor_m", "m", "Monte-Carlo standard deviation along this row's minor axis");
  add_with_interval(t, "ratio_major", "1", "analytic / Monte Carlo along the major axis");
  add_with_interval(t, "ratio_minor", "1", "analytic / Monte Carlo along the minor axis");
  for (int k = 1; k <= 3; ++k)
    add_with_interval(
        t, fmt::format("coverage_{}sigma", k), "1",
        fmt::format("share of trials inside the {}-sigma ellipse; {:.4f} if normal", k, ellipse_coverage(k)));
  add_with_interval(t, "nees", "1", "mean squared Mahalanobis distance from the truth; 2 if consistent");
  t.columns.push_back(number_column("wishart_p", "1", "p-value of the likelihood-ratio test of the 2x2 covariance"));
  t.columns.push_back(number_column("published_ratio_major", "1", "published ratio along the major axis"));
  t.columns.push_back(number_column("published_ratio_minor", "1", "published ratio along the minor axis"));
  t.columns.push_back(word_column("verdict", "both axes agree, one differs, or undecided"));
  t.columns.push_back(word_column("expected", "the verdict this row should have"));
  t.columns.push_back(word_column("note", "what else there is to say"));
  t.columns.push_back(count_column("trials", "trials run"));
  t.columns.push_back(count_column("failed", "trials without a position, not in the statistics"));
  return t;
}

namespace {

const double kNone = std::nan("");

void write_estimate(TableWriter& w, double x, const Interval& i) { w << x << i.lo << i.hi; }
void write_nothing(TableWriter& w) { w << kNone << kNone << kNone; }

void write_counts(TableWriter& w, const HorizontalSample& s) {
  w << static_cast<std::int64_t>(s.trials) << static_cast<std::int64_t>(s.failed);
}

void write_shape(TableWriter& w, const std::string& name, const Eigen::Vector2d& center, const Ellipse& e) {
  w << name << center[0] << center[1] << e.semi_major << e.semi_minor << e.azimuth / kDegree;
}

}  // namespace

void write_sample_ellipse(TableWriter& w, const HorizontalSample& s) {
  if (s.units < 3) return;
  write_shape(w, "monte_carlo", s.mean, ellipse(s.covariance));
  for (int i = 0; i < 8; ++i) write_nothing(w);
  w << kNone << kNone << kNone << std::string() << std::string() << std::string();
  write_counts(w, s);
}

void write_ellipse(TableWriter& w, const EllipseRow& row, const HorizontalSample& s, const VerdictRule& rule) {
  const Ellipse e = ellipse(row.predicted);
  write_shape(w, row.formulation, row.center, e);
  const bool usable = s.units > 2;
  const std::array<double, 2> predicted{e.semi_major, e.semi_minor};
  std::array<double, 2> sd{kNone, kNone};
  std::array<Interval, 2> sd_ci{Interval{kNone, kNone}, Interval{kNone, kNone}}, ratio_ci = sd_ci;
  std::array<std::string, 2> word;
  for (std::size_t a = 0; a < 2 && usable; ++a) {
    sd[a] = std::sqrt(row.along[a].variance);
    sd_ci[a] = sd_interval(row.along[a], rule.confidence);
    ratio_ci[a] = {predicted[a] / sd_ci[a].hi, predicted[a] / sd_ci[a].lo};
    word[a] = judge(ratio_ci[a], rule.margin, s.trials).word;
  }
  for (std::size_t a = 0; a < 2; ++a) write_estimate(w, sd[a], sd_ci[a]);
  for (std::size_t a = 0; a < 2; ++a) write_estimate(w, predicted[a] / sd[a], ratio_ci[a]);
  const bool has_area = usable && e.semi_minor > 0;  // a line covers nothing and has no Mahalanobis distance
  const double count = static_cast<double>(s.paired ? 2 * s.units : s.units);
  for (const std::uint64_t inside : row.inside) {
    if (has_area)
      write_estimate(w, static_cast<double>(inside) / count,
                     s.paired ? paired_binomial_interval(inside, s.units, rule.confidence)
                              : binomial_interval(inside, s.units, rule.confidence));
    else
      write_nothing(w);
  }
  if (has_area)
    write_estimate(w, row.nees.mean, mean_interval(row.nees, rule.confidence));
  else
    write_nothing(w);
  w << (has_area ? row.wishart_p : kNone) << row.published_major << row.published_minor;
  w << (word[0] == "differs" || word[1] == "differs" ? std::string("differs")
        : word[0] == word[1]                         ? word[0]
                                                     : std::string("undecided"));
  w << row.expected << row.note;
  write_counts(w, s);
}

ComparisonRow compare_nees(const std::string& quantity, const SampleSummary& distance, double dimension,
                           const VerdictRule& rule, std::uint64_t trials) {
  ComparisonRow row;
  row.quantity = quantity;
  row.unit = "1";
  row.analytic = dimension;
  if (distance.units < 2) {
    row.note = "fewer than two trials";
    return row;
  }
  row.monte_carlo = distance.mean;
  row.interval = mean_interval(distance, rule.confidence);
  row.ratio = dimension / row.monte_carlo;
  row.ratio_interval = {dimension / row.interval.hi, dimension / row.interval.lo};
  row.verdict = judge(row.ratio_interval, 2 * rule.margin, trials).word;
  const Interval band = nees_band(dimension, distance.units, rule.confidence);
  row.note = fmt::format("consistent predictions give {:.3f} .. {:.3f}", band.lo, band.hi);
  return row;
}

}  // namespace surveymc
