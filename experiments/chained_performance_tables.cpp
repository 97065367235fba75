#include "chained_performance_tables.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/units.h"
#include "stats/normal_tail.h"
#include "study/comparison.h"
#include "study/table_rows.h"

namespace surveymc {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const std::string& name_of(ChainedEstimator e) { return chained_estimator_names()[static_cast<std::size_t>(e)]; }

std::vector<ComparisonRow> rms_rows(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  std::vector<ComparisonRow> rows;
  for (std::size_t e = 0; e < s.estimators.size(); ++e)
    for (std::size_t q = 0; q < kChainedQuantities; ++q) {
      const double claimed = is_chained(s.estimators[e]) && tally.moments.count > 0
                                 ? std::sqrt(tally.moments.mean[layout.numbers.claimed(e, q)])
                                 : kNaN;
      rows.push_back(
          labelled(name_of(s.estimators[e]),
                   compare_value(kChainedQuantityNames[q], kChainedQuantityUnits[q],
                                 rms_estimate(tally.moments, layout.numbers.square(e, q), s.verdict.confidence),
                                 claimed, s.verdict, tally.trials)));
    }
  s.annotations.apply("rms", rows);
  return rows;
}

Table consistency_table(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  std::vector<ComparisonRow> rows;
  const Moments& m = tally.moments;
  const double equations = 3.0 * s.stations();
  for (std::size_t e = 0; e < s.estimators.size(); ++e) {
    if (!is_chained(s.estimators[e])) continue;
    const std::string& name = name_of(s.estimators[e]);
    VerdictRule of_nees = s.verdict;
    of_nees.margin = s.verdict.nees_margin;
    const auto compare = [&](const char* quantity, const Estimate& found, double expected, const VerdictRule& rule) {
      rows.push_back(labelled(name, compare_value(quantity, "1", found, expected, rule, tally.trials)));
    };
    for (std::size_t z = 0; z < kChainedZ; ++z)
      compare(kChainedZNames[z], rms_estimate(m, layout.numbers.z_square(e, z), s.verdict.confidence), 1, s.verdict);
    compare("nees", mean_estimate(m, layout.numbers.nees(e), s.verdict.confidence), kChainedZ, of_nees);
    compare("cost", mean_estimate(m, layout.numbers.cost(e), s.verdict.confidence), equations, s.verdict);
    rows.push_back(labelled(name, compare_sd("cost_sd", "1", 1, m, layout.numbers.cost(e), std::sqrt(2 * equations),
                                             s.verdict, tally.trials)));
  }
  s.annotations.apply("consistency", rows);
  return comparison_table("consistency",
                          "do the covariances claim what the errors are: RMS of z-scores, NEES of twelve states, cost "
                          "against chi-squared(3 stations)" +
                              at_confidence(s.verdict.confidence),
                          rows, tally.trials, tally.failed, true);
}

/// RMS at every station, beside what the covariances claim over all of them.
Table stations_table(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  TableRows t("stations", "RMS errors along the well" + at_confidence(s.verdict.confidence));
  const bool there = layout.along() && !tally.groups.empty();
  for (std::size_t e = 0; e < s.estimators.size(); ++e)
    for (int k = 0; k < (there ? s.stations() : 1); ++k) {
      const auto i = static_cast<std::size_t>(k);
      t.word("formulation", "estimator", name_of(s.estimators[e]));
      t.count("station", "number of the station, from 1", k + 1);
      t.number("md_m", "m", "measured depth", s.md[i]);
      t.number("inclination_profile_deg", "deg", "of the profile", s.truth.attitudes[i].inclination / kDegree);
      for (std::size_t q = 0; q < kChainedQuantities; ++q) {
        const Estimate r =
            there ? rms_estimate(tally.groups[layout.groups.square(e, q)], k, s.verdict.confidence) : Estimate{};
        t.estimate(std::string("rms_") + kChainedQuantityNames[q], kChainedQuantityUnits[q], "RMS error", r.value,
                   r.interval);
      }
    }
  if (!there) t.drop_rows();
  return t.take();
}

/// How often a chained estimator is worse than a single station's.
struct WorseRow {
  std::string formulation, quantity;
  std::uint64_t runs = 0, last = 0;
  double mean_rms = kNaN;
};
Table worse_table(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  const bool compared =
      std::find(s.estimators.begin(), s.estimators.end(), ChainedEstimator::single) != s.estimators.end();
  const std::uint64_t runs = tally.trials - tally.failed;
  std::vector<WorseRow> rows;
  for (std::size_t e = 0; compared && runs > 0 && e < s.estimators.size(); ++e) {
    if (!is_chained(s.estimators[e])) continue;
    for (std::size_t q = 0; q < kChainedQuantities; ++q) {
      const std::uint64_t count = tally.counts[layout.counts.worse_runs(e, q)];
      rows.push_back({name_of(s.estimators[e]), kChainedQuantityNames[q], count,
                      tally.counts[layout.counts.worse_last(e, q)],
                      count > 0 ? tally.moments.mean[layout.numbers.worse(e, q)] *
                                      static_cast<double>(tally.moments.count) / static_cast<double>(count)
                                : kNaN});
    }
  }
  TableRows t("worse", "runs in which chaining is worse than single stations" + at_confidence(s.verdict.confidence));
  write_rows(t, rows, [&](const WorseRow& x) {
    t.word("formulation", "estimator", x.formulation);
    t.word("quantity", "whose error is compared", x.quantity);
    t.count("worse_runs", "runs whose RMS over the stations is above that of the single stations", x.runs);
    t.share("p_worse_run", "their share", x.runs, runs, s.verdict.confidence);
    t.number("mean_rms_worse", "1", "mean RMS of the estimator in these runs, in the quantity's unit", x.mean_rms);
    t.count("worse_last", "runs whose error at the last station is larger than single's", x.last);
    t.share("p_worse_last", "their share", x.last, runs, s.verdict.confidence);
    t.count("trials", "trials run", tally.trials);
    t.count("failed", "trials without a converged estimate, not in the statistics", tally.failed);
  });
  return t.take();
}

/// Scatter of single runs' RMS, and where a published run stands in it.
Table runs_table(const std::vector<ComparisonRow>& rms, const Tally& tally) {
  TableRows t("runs", "RMS over the stations of single runs: their quantiles over the first kept_runs runs");
  const std::size_t n = tally.samples.size() / rms.size();
  for (std::size_t i = 0; i < rms.size(); ++i) {
    std::vector<double> x;
    for (std::size_t r = 0; r < n; ++r) x.push_back(tally.samples[r * rms.size() + i]);
    std::sort(x.begin(), x.end());
    const auto quantile = [&](double p) {
      return n > 0 ? x[static_cast<std::size_t>(p * static_cast<double>(n - 1) + 0.5)] : kNaN;
    };
    const double published = rms[i].published;
    const auto below = std::lower_bound(x.begin(), x.end(), published) - x.begin();
    t.word("formulation", "estimator", rms[i].formulation);
    t.word("quantity", "whose error", rms[i].quantity);
    t.word("unit", "unit of the values in this row", rms[i].unit);
    t.number("q025", "1", "2.5 % of the runs are below", quantile(0.025));
    t.number("median", "1", "half of the runs are below", quantile(0.5));
    t.number("q975", "1", "97.5 % of the runs are below", quantile(0.975));
    t.number("published", "1", "published value of the row in table rms", published);
    t.number("published_rank", "1", "share of the runs below the published value",
             std::isnan(published) ? kNaN : static_cast<double>(below) / static_cast<double>(n));
    t.count("runs", "runs kept", n);
  }
  if (n == 0) t.drop_rows();
  return t.take();
}

/// Counts for figures, with what theory expects.
struct HistogramRow {
  std::string formulation, quantity;
  double from = 0, to = 0;
  std::uint64_t count = 0;
  double expected = 0;
};
Table histogram_table(const ChainedScenario& s, const PerformanceLayout& layout, const Tally& tally) {
  const double runs = static_cast<double>(tally.trials - tally.failed), equations = 3.0 * s.stations();
  constexpr std::size_t kBins = PerformanceLayout::kBins;
  std::vector<HistogramRow> rows;
  for (std::size_t e = 0; e < s.estimators.size() && runs > 0; ++e) {
    if (!is_chained(s.estimators[e])) continue;
    const auto bins = [&](const char* quantity, std::size_t first, double from, double width, double values,
                          const auto& upper_tail) {
      for (std::size_t b = 0; b < kBins; ++b) {
        const double lo = from + width * static_cast<double>(b), hi = lo + width;
        const double above_lo = b == 0 ? 1 : upper_tail(lo), above_hi = b + 1 == kBins ? 0 : upper_tail(hi);
        rows.push_back(
            {name_of(s.estimators[e]), quantity, lo, hi, tally.counts[first + b], values * (above_lo - above_hi)});
      }
    };
    bins("z", layout.counts.z(e), PerformanceLayout::kZFirst, PerformanceLayout::kZWidth,
         runs * s.stations() * static_cast<double>(kChainedZ), [](double x) { return normal_upper_tail(x); });
    bins("nees", layout.counts.nees(e), 0, PerformanceLayout::kNeesWidth, runs * s.stations(),
         [](double x) { return chi_squared_upper_tail(kChainedZ, x); });
    bins("cost", layout.counts.cost(e), 0, layout.cost_width(), runs,
         [&](double x) { return chi_squared_upper_tail(equations, x); });
  }
  TableRows t("histogram",
              "z-scores of all twelve states, NEES of all stations, cost of all runs; the outermost bins hold what "
              "lies beyond");
  write_rows(t, rows, [&](const HistogramRow& x) {
    t.word("formulation", "estimator", x.formulation);
    t.word("quantity", "z, nees or cost", x.quantity);
    t.number("from", "1", "lower edge of the bin", x.from);
    t.number("to", "1", "upper edge of the bin", x.to);
    t.count("count", "values in the bin", x.count);
    t.number("expected", "1", "expected count by theory: normal, chi-squared(12), chi-squared(3 stations)", x.expected);
  });
  return t.take();
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
  return {comparison_table("rms",
                           "RMS errors over all stations and trials; analytic: by the claimed covariances" +
                               at_confidence(s.verdict.confidence),
                           rms, tally.trials, tally.failed, true),
          consistency_table(s, layout, tally),
          stations_table(s, layout, tally),
          worse_table(s, layout, tally),
          runs_table(rms, tally),
          histogram_table(s, layout, tally),
          failed_trials_table("trials without a converged estimate", tally.failed_trials)};
}

}  // namespace surveymc
