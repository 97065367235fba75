#include "chained_performance_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "base/units.h"
#include "study/comparison.h"
#include "study/table_writer.h"

namespace surveymc {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const std::string& name_of(ChainedEstimator e) { return chained_estimator_names()[static_cast<std::size_t>(e)]; }

/// Square root of a mean of squares, with its interval; NaN without trials.
struct Rms {
  double value = kNaN;
  Interval interval{kNaN, kNaN};
};
Rms rms_of(const Moments& m, Eigen::Index i, double confidence) {
  if (m.count < 2) return {};
  const Interval ci = mean_interval(m.mean[i], m.variance(i), m.count, confidence);
  return {std::sqrt(m.mean[i]), {std::sqrt(std::max(ci.lo, 0.0)), std::sqrt(ci.hi)}};
}

/// A root mean square against a prediction of it.
ComparisonRow rms_row(const std::string& formulation, const std::string& quantity, const std::string& unit,
                      const Rms& rms, double analytic, const VerdictRule& rule, std::uint64_t trials) {
  ComparisonRow row;
  row.formulation = formulation;
  row.quantity = quantity;
  row.unit = unit;
  row.monte_carlo = rms.value;
  row.interval = rms.interval;
  row.analytic = analytic;
  if (!std::isfinite(analytic) || !(rms.value > 0)) return row;
  row.ratio = analytic / rms.value;
  row.ratio_interval = {analytic / rms.interval.hi, analytic / rms.interval.lo};
  const Verdict v = judge(row.ratio_interval, rule.margin, trials);
  row.verdict = v.word;
  if (v.trials_to_decide > 0)
    row.note = fmt::format("about {:.2g} trials would decide", static_cast<double>(v.trials_to_decide));
  return row;
}

std::vector<ComparisonRow> rms_rows(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  std::vector<ComparisonRow> rows;
  for (std::size_t e = 0; e < s.estimators.size(); ++e)
    for (std::size_t q = 0; q < kChainedQuantities; ++q) {
      const Moments& m = layout.moments(tally, e);
      const double claimed = is_chained(s.estimators[e]) && m.count > 0 ? std::sqrt(m.mean[layout.claimed(q)]) : kNaN;
      rows.push_back(rms_row(name_of(s.estimators[e]), kChainedQuantityNames[q], kChainedQuantityUnits[q],
                             rms_of(m, layout.square(q), s.verdict.confidence), claimed, s.verdict, tally.trials));
    }
  s.annotations.apply("rms", rows);
  return rows;
}

/// Rows of a comparison by estimator, each with the trials that its own estimator failed in.
Table by_estimator(Table t, const std::vector<ComparisonRow>& rows, const ChainedScenario& s,
                   const PerformanceLayout& layout, const Tally& tally) {
  std::vector<std::int64_t> failed;
  for (const ComparisonRow& row : rows)
    for (std::size_t e = 0; e < s.estimators.size(); ++e)
      if (row.formulation == name_of(s.estimators[e]))
        failed.push_back(static_cast<std::int64_t>(layout.failed(tally, e)));
  t.columns.back().values = std::move(failed);
  return t;
}

/// A mean that theory knows, judged as a ratio.
ComparisonRow mean_row(const std::string& formulation, const std::string& quantity, const Moments& m, Eigen::Index i,
                       double analytic, const VerdictRule& rule, std::uint64_t trials) {
  Rms mean;
  if (m.count >= 2) mean = {m.mean[i], mean_interval(m.mean[i], m.variance(i), m.count, rule.confidence)};
  return rms_row(formulation, quantity, "1", mean, analytic, rule, trials);
}

Table consistency_table(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  std::vector<ComparisonRow> rows;
  const double equations = 3.0 * s.stations();
  for (std::size_t e = 0; e < s.estimators.size(); ++e) {
    if (!is_chained(s.estimators[e])) continue;
    const Moments& m = layout.moments(tally, e);
    const std::string& name = name_of(s.estimators[e]);
    for (std::size_t z = 0; z < kChainedZ; ++z)
      rows.push_back(rms_row(name, kChainedZNames[z], "1", rms_of(m, layout.z_square(z), s.verdict.confidence), 1,
                             s.verdict, tally.trials));
    rows.push_back(mean_row(name, "nees", m, layout.nees(), kChainedZ, s.verdict, tally.trials));
    rows.push_back(mean_row(name, "cost", m, layout.cost(), equations, s.verdict, tally.trials));
    ComparisonRow sd =
        compare_sd("cost_sd", "1", 1, m, layout.cost(), std::sqrt(2 * equations), s.verdict, tally.trials);
    sd.formulation = name;
    rows.push_back(sd);
  }
  s.annotations.apply("consistency", rows);
  return by_estimator(
      comparison_table("consistency",
                       "do the covariances claim what the errors are: RMS of z-scores, NEES of twelve states, cost "
                       "against chi-squared(3 stations)" +
                           at_confidence(s.verdict.confidence),
                       rows, tally.trials, tally.failed, true),
      rows, s, layout, tally);
}

/// RMS at every station, beside what the covariances claim over all of them.
Table stations_table(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  Table t{"stations", "RMS errors along the well" + at_confidence(s.verdict.confidence)};
  t.columns = {word_column("formulation", "estimator"), count_column("station", "number of the station, from 1"),
               number_column("md_m", "m", "measured depth"),
               number_column("inclination_profile_deg", "deg", "of the profile")};
  for (std::size_t q = 0; q < kChainedQuantities; ++q)
    add_with_interval(t, std::string("rms_") + kChainedQuantityNames[q], kChainedQuantityUnits[q], "RMS error");
  TableWriter w(std::move(t));
  if (layout.along() && !tally.groups.empty())
    for (std::size_t e = 0; e < s.estimators.size(); ++e)
      for (int k = 0; k < s.stations(); ++k) {
        const auto i = static_cast<std::size_t>(k);
        w << name_of(s.estimators[e]) << static_cast<std::int64_t>(k + 1) << s.md[i]
          << s.truth.attitudes[i].inclination / kDegree;
        for (std::size_t q = 0; q < kChainedQuantities; ++q) {
          const Rms r = rms_of(tally.groups[layout.group(e, q)], k, s.verdict.confidence);
          w << r.value << r.interval.lo << r.interval.hi;
        }
      }
  return w.take();
}

/// How often a chained estimator is worse than a single station's.
Table worse_table(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  Table t{"worse", "runs in which chaining is worse than single stations" + at_confidence(s.verdict.confidence)};
  t.columns = {word_column("formulation", "estimator"), word_column("quantity", "whose error is compared"),
               count_column("worse_runs", "runs whose RMS over the stations is above that of the single stations")};
  add_with_interval(t, "p_worse_run", "1", "their share");
  t.columns.push_back(number_column("mean_rms_worse", "1",
                                    "mean RMS of the estimator in these runs, in the quantity's "
                                    "unit"));
  t.columns.push_back(count_column("worse_last", "runs whose error at the last station is larger than single's"));
  add_with_interval(t, "p_worse_last", "1", "their share");
  t.columns.push_back(count_column("trials", "trials run"));
  t.columns.push_back(count_column("failed", "trials without a converged estimate, not in the statistics"));
  TableWriter w(std::move(t));
  const bool compared =
      std::find(s.estimators.begin(), s.estimators.end(), ChainedEstimator::single) != s.estimators.end();
  for (std::size_t e = 0; compared && e < s.estimators.size(); ++e) {
    const Moments& m = layout.moments(tally, e);
    const std::uint64_t runs = m.count;
    if (!is_chained(s.estimators[e]) || runs == 0) continue;
    for (std::size_t q = 0; q < kChainedQuantities; ++q) {
      w << name_of(s.estimators[e]) << std::string(kChainedQuantityNames[q]);
      const auto share = [&](std::uint64_t count) {
        const Interval ci = binomial_interval(count, runs, s.verdict.confidence);
        w << static_cast<double>(count) / static_cast<double>(runs) << ci.lo << ci.hi;
      };
      const std::uint64_t count = tally.counts[layout.worse_runs(e, q)], last = tally.counts[layout.worse_last(e, q)];
      w << static_cast<std::int64_t>(count);
      share(count);
      w << (count > 0 ? m.mean[layout.worse(q)] * static_cast<double>(runs) / static_cast<double>(count) : kNaN)
        << static_cast<std::int64_t>(last);
      share(last);
      w << static_cast<std::int64_t>(tally.trials) << static_cast<std::int64_t>(layout.failed(tally, e));
    }
  }
  return w.take();
}

/// Scatter of single runs' RMS, and where a published run stands in it.
Table runs_table(const std::vector<ComparisonRow>& rms, const Tally& tally) {
  Table t{"runs", "RMS over the stations of single runs: their quantiles over the first kept_runs runs"};
  t.columns = {word_column("formulation", "estimator"),
               word_column("quantity", "whose error"),
               word_column("unit", "unit of the values in this row"),
               number_column("q025", "1", "2.5 % of the runs are below"),
               number_column("median", "1", "half of the runs are below"),
               number_column("q975", "1", "97.5 % of the runs are below"),
               number_column("published", "1", "published value of the row in table rms"),
               number_column("published_rank", "1", "share of the runs below the published value"),
               count_column("runs", "runs kept")};
  TableWriter w(std::move(t));
  const std::size_t n = tally.samples.size() / rms.size();
  for (std::size_t i = 0; i < rms.size() && n > 0; ++i) {
    std::vector<double> x;
    for (std::size_t r = 0; r < n; ++r)
      if (const double sample = tally.samples[r * rms.size() + i]; !std::isnan(sample)) x.push_back(sample);
    if (x.empty()) continue;
    std::sort(x.begin(), x.end());
    const auto quantile = [&](double p) {
      return x[static_cast<std::size_t>(p * static_cast<double>(x.size() - 1) + 0.5)];
    };
    const auto below = std::lower_bound(x.begin(), x.end(), rms[i].published) - x.begin();
    w << rms[i].formulation << rms[i].quantity << rms[i].unit << quantile(0.025) << quantile(0.5) << quantile(0.975)
      << rms[i].published
      << (std::isnan(rms[i].published) ? kNaN : static_cast<double>(below) / static_cast<double>(x.size()))
      << static_cast<std::int64_t>(x.size());
  }
  return w.take();
}

/// Counts for figures, with what theory expects.
Table histogram_table(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  Table t{"histogram",
          "z-scores of all twelve states, NEES of all stations, cost of all runs; the outermost bins hold "
          "what lies beyond"};
  t.columns = {word_column("formulation", "estimator"),
               word_column("quantity", "z, nees or cost"),
               number_column("from", "1", "lower edge of the bin"),
               number_column("to", "1", "upper edge of the bin"),
               count_column("count", "values in the bin"),
               number_column("expected", "1",
                             "expected count by theory: normal, chi-squared(12), chi-squared(3 "
                             "stations)")};
  TableWriter w(std::move(t));
  const double equations = 3.0 * s.stations();
  constexpr std::size_t kBins = PerformanceLayout::kBins;
  for (std::size_t e = 0; e < s.estimators.size(); ++e) {
    const double runs = static_cast<double>(layout.moments(tally, e).count);
    if (!is_chained(s.estimators[e]) || runs == 0) continue;
    const auto bins = [&](const char* quantity, std::size_t first, double from, double width, double values,
                          const auto& upper_tail) {
      for (std::size_t b = 0; b < kBins; ++b) {
        const double lo = from + width * static_cast<double>(b), hi = lo + width;
        const double above_lo = b == 0 ? 1 : upper_tail(lo), above_hi = b + 1 == kBins ? 0 : upper_tail(hi);
        w << name_of(s.estimators[e]) << std::string(quantity) << lo << hi
          << static_cast<std::int64_t>(tally.counts[first + b]) << values * (above_lo - above_hi);
      }
    };
    bins("z", layout.z_bin(e), PerformanceLayout::kZFirst, PerformanceLayout::kZWidth,
         runs * s.stations() * static_cast<double>(kChainedZ),
         [](double x) { return std::erfc(x / std::sqrt(2.0)) / 2; });
    bins("nees", layout.nees_bin(e), 0, PerformanceLayout::kNeesWidth, runs * s.stations(),
         [](double x) { return chi_squared_upper_tail(kChainedZ, x); });
    bins("cost", layout.cost_bin(e), 0, layout.cost_width(), runs,
         [&](double x) { return chi_squared_upper_tail(equations, x); });
  }
  return w.take();
}

/// How every chained estimator ended, by reason.
Table failures_table(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  Table t{"failures", "how the trials of every chained estimator ended; each leaves out its own failures only"};
  t.columns = {word_column("formulation", "estimator"),
               word_column("status", "converged, or why not: iteration_limit, no_descent, saddle, not_finite"),
               count_column("count", "trials"), count_column("trials", "trials run")};
  TableWriter w(std::move(t));
  for (std::size_t e = 0; e < s.estimators.size() && !tally.counts.empty(); ++e)
    for (std::size_t i = 0; is_chained(s.estimators[e]) && i < kChainedStatuses; ++i)
      w << name_of(s.estimators[e]) << std::string(kChainedStatusNames[i])
        << static_cast<std::int64_t>(tally.counts[layout.ended(e, static_cast<ChainedStatus>(i))])
        << static_cast<std::int64_t>(tally.trials);
  return w.take();
}

}  // namespace

std::vector<RowName> performance_rows(const ChainedScenario& s) {
  std::vector<RowName> rows;
  for (const ChainedEstimator e : s.estimators) {
    for (const char* q : kChainedQuantityNames) rows.push_back({"rms", name_of(e), q});
    if (!is_chained(e)) continue;
    for (const char* q : kChainedZNames) rows.push_back({"consistency", name_of(e), q});
    for (const char* q : {"nees", "cost", "cost_sd"}) rows.push_back({"consistency", name_of(e), q});
  }
  return rows;
}

std::vector<Table> performance_tables(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  const std::vector<ComparisonRow> rms = rms_rows(s, layout, tally);
  Table failures{
      "failed_trials",
      "trials without a converged estimate of some estimator; replay one with `surveymc run CONFIG --trial K`"};
  failures.columns = {{"trial", "1", "number of the trial, from 0",
                       std::vector<std::int64_t>(tally.failed_trials.begin(), tally.failed_trials.end())}};
  return {
      by_estimator(comparison_table("rms",
                                    "RMS errors over all stations and trials; analytic: by the claimed covariances" +
                                        at_confidence(s.verdict.confidence),
                                    rms, tally.trials, tally.failed, true),
                   rms, s, layout, tally),
      consistency_table(s, layout, tally),
      stations_table(s, layout, tally),
      worse_table(s, layout, tally),
      runs_table(rms, tally),
      histogram_table(s, layout, tally),
      failures_table(s, layout, tally),
      failures};
}

}  // namespace surveymc
