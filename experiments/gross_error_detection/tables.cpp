#include "gross_error_detection/tables.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/comparison.h"
#include "compare/table_rows.h"
#include "reliability/nonlinear_detectable.h"
#include "reliability/snooping.h"
#include "stats/intervals.h"

namespace surveymc::studies::gross_error_detection {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Prediction = analysis::GrossErrorPrediction;

constexpr double kMostFailed = 0.01;  // share of trials without a converged adjustment above which nothing is judged

/// The test that is most correlated with that of `number`, tied ones included.
struct Rival {
  Index number = -1;
  double correlation = 0;
};
Rival closest_rival(const reliability::ParityModel& m, Index number) {
  const Eigen::MatrixXd rho = reliability::test_correlations(m);
  Rival r;
  for (Index i = 0; i < m.observations(); ++i)
    if (i != number && std::abs(rho(number, i)) > std::abs(r.correlation)) r = {i, rho(number, i)};
  return r;
}

/// linear_rates is good to 2e-4: too little to judge small rates by.
double if_large(double rate) { return rate >= 0.01 ? rate : kNaN; }

/// Of a single error and strategy single; NaN where it is not known.
double outcome_rate(const Prediction& p, SnoopingOutcome outcome) {
  if (std::isnan(p.any)) return kNaN;
  const bool known = !std::isnan(p.identified);
  switch (outcome) {
    case SnoopingOutcome::identified:
      return !known ? kNaN : p.in_group ? 0 : if_large(p.identified);
    case SnoopingOutcome::group:
      return !known || (!p.in_group && p.may_be_tied) ? kNaN : p.in_group ? if_large(p.identified) : 0;
    case SnoopingOutcome::partly:
      return 0;
    case SnoopingOutcome::wrong:
      return if_large(p.any - p.identified);
    case SnoopingOutcome::missed:
      return if_large(1 - p.any);
  }
  return kNaN;
}

std::string name_of(const Scenario& s, Index number) {
  const auto i = static_cast<std::size_t>(number), readings = reliability::kReadings * s.attitudes.size();
  if (i >= readings + 3) return fmt::format("systematic_term_{}", i - readings - 3);
  if (i >= readings) return reliability::observation_names()[reliability::kReadings + i - readings];
  const std::string& name = reliability::observation_names()[i % reliability::kReadings];
  return s.attitudes.size() > 1 ? fmt::format("{}_{}", name, i / reliability::kReadings) : name;
}

}  // namespace

std::vector<compare::Row> rows_of(const Scenario& s, const Prediction* p) {
  const EventLayout layout{s.injected.size(), s.strategies.size()};
  std::vector<compare::Row> rows;
  const auto add = [&](const std::string& formulation, const std::string& quantity, std::size_t event,
                       const auto& prediction) -> compare::Row& {
    return rows.emplace_back(compare::Row{.table = "detection",
                                          .formulation = formulation,
                                          .quantity = quantity,
                                          .unit = "1",
                                          .component = static_cast<int>(event),
                                          .prediction = p ? prediction(*p) : kNaN});
  };

  // What linear theory does not control at the true attitude has a test at the trials' own.
  const auto alpha = [](const Prediction& q) { return q.two_sided_alpha; };
  for (std::size_t k = 0; k < s.injected.size(); ++k)
    add("design", "false_alarm_" + s.injected[k].label, layout.false_alarm(k), alpha);
  add("design", "false_alarm_mean", 0, alpha).statistic = compare::Statistic::mean;
  add("design", "false_alarm_any", layout.false_alarm_any(), [](const Prediction& q) { return q.false_alarm_any; });
  add("design", "false_alarm_general", layout.false_alarm_general(),
      [](const Prediction& q) { return q.general.alpha; });
  if (s.injected.empty()) return rows;  // nothing to detect

  for (const bool linear : {true, false}) {
    const char* formulation = linear ? "linear" : "nonlinear";
    const auto shift = [linear](const Prediction& q) -> const analysis::ErrorShift& {
      return linear ? q.linear : q.nonlinear;
    };
    for (std::size_t k = 0; k < s.injected.size(); ++k)
      add(formulation, "detection_" + s.injected[k].label, layout.detection(k),
          [&](const Prediction& q) { return analysis::single_test_power(q, shift(q), k, s.pope); });
    add(formulation, "detection_any", layout.detection_any(),
        [&](const Prediction& q) { return linear ? q.linear_any : q.any; });
    add(formulation, "detection_general", layout.detection_general(), [&](const Prediction& q) {
      const double omega = shift(q).omega;
      return std::isnan(omega) ? kNaN : reliability::chi_squared_power(q.redundancy, omega, q.general.critical);
    });
  }
  for (std::size_t k = 0; k < s.strategies.size(); ++k)
    for (std::size_t o = 0; o < kOutcomes; ++o) {
      const bool predicted = s.strategies[k] == SnoopingStrategy::single && s.injected.size() == 1;
      add(strategy_names()[static_cast<std::size_t>(s.strategies[k])], outcome_names()[o], layout.outcome(k, o),
          [&](const Prediction& q) { return predicted ? outcome_rate(q, static_cast<SnoopingOutcome>(o)) : kNaN; })
          .predicted = predicted;
    }
  return rows;
}

std::vector<compare::ComparisonRow> detection_rows(const Scenario& s, const Prediction& p, const stats::Tally& tally) {
  const EventLayout layout{s.injected.size(), s.strategies.size()};
  const std::uint64_t runs = tally.trials - tally.failed;
  const stats::Moments& m = tally.moments;
  const double confidence = s.verdict.interval_confidence(m.count);
  std::vector<compare::ComparisonRow> rows;
  for (const compare::Row& row : rows_of(s, &p)) {
    const auto event = static_cast<std::size_t>(row.component);
    const compare::VerdictRule rule =
        row.formulation == "design" ? s.verdict.with_margin(s.false_alarm_margin) : s.verdict;
    if (row.statistic == compare::Statistic::mean) {
      compare::Estimate share = compare::mean_estimate(m, 0, confidence);
      if (m.count > 1)  // a share: its interval must not leave [0, 1]
        share.interval = stats::share_interval(share.value, m.variance(0), m.count, confidence);
      rows.push_back(
          compare::compare_value(row.quantity, row.unit, share, row.prediction, rule, tally.trials, m.count));
      rows.back().note = m.count > 1 ? "mean over all observations that can be tested" : "";
    } else {
      rows.push_back(compare::compare_rate(row.quantity, tally.counts.empty() ? 0 : tally.counts[event], runs,
                                           row.prediction, rule, tally.trials));
      if (event == layout.false_alarm_general())
        rows.back().note += fmt::format("{}chi2 above {:.4f}, level by the B-method",
                                        rows.back().note.empty() ? "" : "; ", p.general.critical);
    }
    rows.back().formulation = row.formulation;
  }
  compare::leave_undecided(rows, tally.failed, tally.trials, kMostFailed, "adjustments");
  return rows;
}

store::Table detection_table(const Scenario& s, const analysis::GrossErrorPrediction& p,
                             const compare::VerdictStop& stop, const stats::Tally& tally) {
  std::vector<compare::ComparisonRow> rows = detection_rows(s, p, tally);
  stop.add_notes("detection", rows, tally);
  s.annotations.apply("detection", rows);
  return compare::comparison_table(
      "detection", "false alarms, detection and identification of gross errors" + compare::at_confidence(s.verdict),
      rows, tally.trials, tally.failed);
}

store::Table injected_table(const Scenario& s, const analysis::GrossErrorPrediction& p) {
  compare::TableRows t("injected", "the gross errors, and what theory says of them");
  const double lambda = reliability::lambda0(s.levels);
  const VectorXd redundancy = reliability::redundancy_numbers(p.model),
                 sensitivity = reliability::sensitivities(p.model);
  const bool single = s.attitudes.size() == 1 && !s.model.systematic_terms;
  std::size_t k = 0;
  compare::write_rows(t, s.injected, [&](const InjectedError& e) {
    const double unit = reliability::observation_scale(e.observation), size = sensitivity[e.error.number];
    const auto nonlinear = [&](int sign, reliability::DetectedBy test) {
      return single ? reliability::nonlinear_detectable_error(s.model, s.attitudes.front(), e.observation, lambda, sign,
                                                              test) *
                          unit
                    : kNaN;
    };
    const auto shift = [&](const analysis::ErrorShift& x) { return k < x.w.size() ? x.w[k] : kNaN; };
    const Rival rival = closest_rival(p.model, e.error.number);
    t.word("observation", "in which the error is", reliability::observation_names()[e.observation]);
    t.count("station", "number of the station, from 0; -1: a reference",
            e.observation < reliability::kReadings ? static_cast<std::int64_t>(e.station) : std::int64_t{-1});
    t.word("unit", "of the sizes in this row", reliability::observation_unit(e.observation));
    t.number("size", "1", "the error, in the row's unit", e.error.size * unit);
    t.number("minimal_detectable_error", "1", "linear, in the row's unit", size > 0 ? lambda / size * unit : kInfinity);
    t.number("nonlinear_detectable_error_plus", "1",
             "nonlinear, by the general test, in the row's unit; single station only",
             nonlinear(1, reliability::DetectedBy::general_test));
    t.number("nonlinear_detectable_error_minus", "1", "the same for negative errors",
             nonlinear(-1, reliability::DetectedBy::general_test));
    t.number("nonlinear_own_test_plus", "1", "nonlinear, by the reading's own test",
             nonlinear(1, reliability::DetectedBy::own_test));
    t.number("nonlinear_own_test_minus", "1", "the same for negative errors",
             nonlinear(-1, reliability::DetectedBy::own_test));
    t.number("redundancy_number", "1", "redundancy number", redundancy[e.error.number]);
    t.number("shift_linear", "1", "of its w by all errors, linear theory", shift(p.linear));
    t.number("shift_nonlinear", "1", "of its w by all errors, nonlinear adjustment without noise", shift(p.nonlinear));
    t.word("rival", "the observation whose test is most correlated with its own",
           rival.number < 0 ? std::string() : name_of(s, rival.number));
    t.number("rival_correlation", "1", "correlation of the two; 1 or -1: inseparable",
             rival.number < 0 ? kNaN : rival.correlation);
    ++k;
  });
  return t.take();
}

}  // namespace surveymc::studies::gross_error_detection
