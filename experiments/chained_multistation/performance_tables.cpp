#include "chained_multistation/performance_tables.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "compare/comparison.h"
#include "compare/table_rows.h"
#include "stats/normal_tail.h"

namespace surveymc::studies::chained_multistation {
namespace {

const std::string& name_of(Solver e) { return solver_names()[static_cast<std::size_t>(e)]; }

std::vector<compare::ComparisonRow> rms_rows(const Scenario& s, const PerformanceLayout& layout,
                                             const stats::Tally& tally) {
  std::vector<compare::ComparisonRow> rows;
  for (std::size_t e = 0; e < s.estimators.size(); ++e)
    for (std::size_t q = 0; q < kRunQuantities; ++q) {
      const stats::Moments& m = layout.moments(tally, e);
      const double claimed =
          is_chained(s.estimators[e]) && m.count > 0 ? std::sqrt(m.mean[layout.numbers.claimed(q)]) : kNaN;
      rows.push_back(compare::labelled(
          name_of(s.estimators[e]),
          compare::compare_value(
              kRunQuantityNames[q], kRunQuantityUnits[q],
              compare::rms_estimate(m, layout.numbers.square(q), s.verdict.interval_confidence(m.count)), claimed,
              s.verdict, tally.trials, m.count)));
      rows.back().failed = layout.failed(tally, e);
    }
  return rows;
}

std::vector<compare::ComparisonRow> consistency_rows(const Scenario& s, const PerformanceLayout& layout,
                                                     const stats::Tally& tally) {
  std::vector<compare::ComparisonRow> rows;
  const double equations = 3.0 * s.stations();
  for (std::size_t e = 0; e < s.estimators.size(); ++e) {
    if (!is_chained(s.estimators[e])) continue;
    const std::size_t first = rows.size();
    const stats::Moments& m = layout.moments(tally, e);
    const std::string& name = name_of(s.estimators[e]);
    const double confidence = s.verdict.interval_confidence(m.count);
    compare::VerdictRule of_nees = s.verdict;
    of_nees.margin = s.verdict.nees_margin;
    const auto compare = [&](const char* quantity, const compare::Estimate& found, double expected,
                             const compare::VerdictRule& rule) {
      rows.push_back(
          compare::labelled(name, compare::compare_value(quantity, "1", found, expected, rule, tally.trials, m.count)));
    };
    for (std::size_t z = 0; z < kTestedStates; ++z)
      compare(kTestedStateNames[z], compare::rms_estimate(m, layout.numbers.z_square(z), confidence), 1, s.verdict);
    compare("nees", compare::mean_estimate(m, layout.numbers.nees(), confidence), kTestedStates, of_nees);
    compare("cost", compare::mean_estimate(m, layout.numbers.cost(), confidence), equations, s.verdict);
    rows.push_back(compare::labelled(name, compare::compare_sd("cost_sd", "1", 1, m, layout.numbers.cost(),
                                                               std::sqrt(2 * equations), s.verdict, tally.trials)));
    for (std::size_t i = first; i < rows.size(); ++i) rows[i].failed = layout.failed(tally, e);
  }
  return rows;
}

store::Table consistency_table(const Scenario& s, const PerformanceLayout& layout, const compare::VerdictStop& stop,
                               const stats::Tally& tally) {
  std::vector<compare::ComparisonRow> rows = consistency_rows(s, layout, tally);
  stop.add_notes("consistency", rows, tally);
  s.annotations.apply("consistency", rows);
  return compare::comparison_table(
      "consistency",
      "do the covariances claim what the errors are: RMS of z-scores, NEES of twelve states, cost "
      "against chi-squared(3 stations)" +
          compare::at_confidence(s.verdict),
      rows, tally.trials, tally.failed, true);
}

/// RMS at every station, beside the claims of the covariances over all stations.
store::Table stations_table(const Scenario& s, const PerformanceLayout& layout, const stats::Tally& tally) {
  compare::TableRows t("stations", "RMS errors along the well" + compare::at_confidence(s.verdict));
  const bool there = layout.along() && !tally.groups.empty();
  for (std::size_t e = 0; e < s.estimators.size(); ++e)
    for (int k = 0; k < (there ? s.stations() : 1); ++k) {
      const auto i = static_cast<std::size_t>(k);
      t.word("formulation", "estimator", name_of(s.estimators[e]));
      t.count("station", "number of the station, from 1", k + 1);
      t.number("md_m", "m", "measured depth", s.md[i]);
      t.number("inclination_profile_deg", "deg", "of the profile", s.truth.attitudes[i].inclination / kDegree);
      for (std::size_t q = 0; q < kRunQuantities; ++q) {
        const compare::Estimate r =
            there ? compare::rms_estimate(tally.groups[layout.groups.square(e, q)], k,
                                          s.verdict.interval_confidence(layout.moments(tally, e).count))
                  : compare::Estimate{};
        t.estimate(std::string("rms_") + kRunQuantityNames[q], kRunQuantityUnits[q], "RMS error", r.value, r.interval);
      }
    }
  if (!there) t.drop_rows();
  return t.take();
}

/// How often a chained estimator is worse than a single station's.
struct WorseRow {
  std::string formulation, quantity;
  std::uint64_t worse = 0, last = 0, runs = 0, failed = 0;  ///< `runs`: that the estimator solved
  double mean_rms = kNaN;
};
store::Table worse_table(const Scenario& s, const PerformanceLayout& layout, const stats::Tally& tally) {
  const bool compared = std::find(s.estimators.begin(), s.estimators.end(), Solver::single) != s.estimators.end();
  std::vector<WorseRow> rows;
  for (std::size_t e = 0; compared && e < s.estimators.size(); ++e) {
    const stats::Moments& m = layout.moments(tally, e);
    if (!is_chained(s.estimators[e]) || m.count == 0) continue;
    for (std::size_t q = 0; q < kRunQuantities; ++q) {
      const std::uint64_t count = tally.counts[layout.counts.worse_runs(e, q)];
      rows.push_back({name_of(s.estimators[e]), kRunQuantityNames[q], count,
                      tally.counts[layout.counts.worse_last(e, q)], m.count, layout.failed(tally, e),
                      count > 0
                          ? m.mean[layout.numbers.worse(q)] * static_cast<double>(m.count) / static_cast<double>(count)
                          : kNaN});
    }
  }
  compare::TableRows t("worse",
                       "runs in which chaining is worse than single stations" + compare::at_confidence(s.verdict));
  compare::write_rows(t, rows, [&](const WorseRow& x) {
    t.word("formulation", "estimator", x.formulation);
    t.word("quantity", "whose error is compared", x.quantity);
    t.count("worse_runs", "runs whose RMS over the stations is above that of the single stations", x.worse);
    t.share("p_worse_run", "their share", x.worse, x.runs, s.verdict.interval_confidence(x.runs));
    t.number("mean_rms_worse", "1", "mean RMS of the estimator in these runs, in the quantity's unit", x.mean_rms);
    t.count("worse_last", "runs whose error at the last station is larger than single's", x.last);
    t.share("p_worse_last", "their share", x.last, x.runs, s.verdict.interval_confidence(x.runs));
    t.count("trials", "trials run", tally.trials);
    t.count("failed", "trials without a converged estimate, not in the statistics", x.failed);
  });
  return t.take();
}

/// Scatter of single runs' RMS, and where a published run stands in it.
store::Table runs_table(const std::vector<compare::ComparisonRow>& rms, const stats::Tally& tally) {
  compare::TableRows t("runs", "RMS over the stations of single runs: their quantiles over the first kept_runs runs");
  const std::size_t n = tally.samples.size() / rms.size();
  for (std::size_t i = 0; i < rms.size(); ++i) {
    std::vector<double> x;
    for (std::size_t r = 0; r < n; ++r)
      if (const double sample = tally.samples[r * rms.size() + i]; !std::isnan(sample)) x.push_back(sample);
    std::sort(x.begin(), x.end());
    const auto quantile = [&](double p) {
      return x.empty() ? kNaN : x[static_cast<std::size_t>(p * static_cast<double>(x.size() - 1) + 0.5)];
    };
    const double published = rms[i].published;
    const auto below = std::lower_bound(x.begin(), x.end(), published) - x.begin();
    const bool placed = !std::isnan(published) && !x.empty();
    t.word("formulation", "estimator", rms[i].formulation);
    t.word("quantity", "whose error", rms[i].quantity);
    t.word("unit", "unit of the values in this row", rms[i].unit);
    t.number("q025", "1", "2.5 % of the runs are below", quantile(0.025));
    t.number("median", "1", "half of the runs are below", quantile(0.5));
    t.number("q975", "1", "97.5 % of the runs are below", quantile(0.975));
    t.number("published", "1", "published value of the row in table rms", published);
    t.number("published_rank", "1", "share of the runs below the published value",
             placed ? static_cast<double>(below) / static_cast<double>(x.size()) : kNaN);
    t.count("runs", "runs kept", x.size());
  }
  if (n == 0) t.drop_rows();
  return t.take();
}

/// Counts for figures, with the counts that theory expects.
struct HistogramRow {
  std::string formulation, quantity;
  double from = 0, to = 0;
  std::uint64_t count = 0;
  double expected = 0;
};
store::Table histogram_table(const Scenario& s, const PerformanceLayout& layout, const stats::Tally& tally) {
  const double equations = 3.0 * s.stations();
  constexpr std::size_t kBins = PerformanceLayout::kBins;
  std::vector<HistogramRow> rows;
  for (std::size_t e = 0; e < s.estimators.size(); ++e) {
    const double runs = static_cast<double>(layout.moments(tally, e).count);
    if (!is_chained(s.estimators[e]) || runs == 0) continue;
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
         runs * s.stations() * static_cast<double>(kTestedStates),
         [](double x) { return stats::normal_upper_tail(x); });
    bins("nees", layout.counts.nees(e), 0, PerformanceLayout::kNeesWidth, runs * s.stations(),
         [](double x) { return stats::chi_squared_upper_tail(kTestedStates, x); });
    bins("cost", layout.counts.cost(e), 0, layout.cost_width(), runs,
         [&](double x) { return stats::chi_squared_upper_tail(equations, x); });
  }
  compare::TableRows t(
      "histogram",
      "z-scores of all twelve states, NEES of all stations, cost of all runs; the outermost bins hold what "
      "lies beyond");
  compare::write_rows(t, rows, [&](const HistogramRow& x) {
    t.word("formulation", "estimator", x.formulation);
    t.word("quantity", "z, nees or cost", x.quantity);
    t.number("from", "1", "lower edge of the bin", x.from);
    t.number("to", "1", "upper edge of the bin", x.to);
    t.count("count", "values in the bin", x.count);
    t.number("expected", "1", "expected count by theory: normal, chi-squared(12), chi-squared(3 stations)", x.expected);
  });
  return t.take();
}

/// How every chained estimator ended, by reason.
store::Table failures_table(const Scenario& s, const PerformanceLayout& layout, const stats::Tally& tally) {
  std::vector<Endings> endings;
  for (std::size_t e = 0; e < s.estimators.size(); ++e)
    if (is_chained(s.estimators[e])) endings.push_back({name_of(s.estimators[e]), layout.counts.ended(e)});
  return endings_table("how the trials of every chained estimator ended; each leaves out its own failures only",
                       "formulation", "estimator", endings, tally);
}

}  // namespace

std::vector<compare::Row> rows_of(const Scenario& s) {
  std::vector<compare::Row> rows;
  for (const Solver e : s.estimators) {  // trials decide what is claimed; a NEES has no confidence sequence
    for (const char* q : kRunQuantityNames)
      rows.push_back({.table = "rms", .formulation = name_of(e), .quantity = q, .predicted = is_chained(e)});
    if (!is_chained(e)) continue;
    for (const char* q : kTestedStateNames)
      rows.push_back({.table = "consistency", .formulation = name_of(e), .quantity = q});
    for (const std::string q : {"nees", "cost", "cost_sd"})
      rows.push_back({.table = "consistency", .formulation = name_of(e), .quantity = q, .predicted = q != "nees"});
  }
  for (const Solver e : s.estimators) {
    if (!is_chained(e)) continue;
    const auto calibrated = [&](const std::string& quantity) {
      rows.push_back({.table = "calibration", .formulation = name_of(e), .quantity = quantity, .calibrated = true});
    };
    for (const char* place : {"first", "middle", "last"}) {
      for (const char* state : kTestedStateNames) calibrated(fmt::format("{}_{}", state + 2, place));
      calibrated(fmt::format("nees_{}", place));
    }
    calibrated("cost");
  }
  return rows;
}

compare::RowsOfTables performance_rows(const Scenario& s, const PerformanceLayout& layout, const stats::Tally& tally) {
  return {{"rms", rms_rows(s, layout, tally)}, {"consistency", consistency_rows(s, layout, tally)}};
}

std::vector<store::Table> performance_tables(const Scenario& s, const PerformanceLayout& layout,
                                             const compare::VerdictStop& stop, const stats::Tally& tally) {
  std::vector<compare::ComparisonRow> rms = rms_rows(s, layout, tally);
  stop.add_notes("rms", rms, tally);
  s.annotations.apply("rms", rms);
  std::vector<store::Table> tables{
      compare::comparison_table("rms",
                                "RMS errors over all stations and trials; analytic: by the claimed covariances" +
                                    compare::at_confidence(s.verdict),
                                rms, tally.trials, tally.failed, true),
      consistency_table(s, layout, stop, tally),
      stations_table(s, layout, tally),
      worse_table(s, layout, tally),
      runs_table(rms, tally),
      histogram_table(s, layout, tally),
      failures_table(s, layout, tally),
      compare::failed_trials_table("trials without a converged estimate of some estimator", tally.failed_trials)};
  if (stop.is_on()) tables.push_back(stop.looks_table(tally));
  return tables;
}

}  // namespace surveymc::studies::chained_multistation
