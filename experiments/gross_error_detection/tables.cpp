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

std::string name_of(const Scenario& s, Index number) {
  const auto i = static_cast<std::size_t>(number), readings = reliability::kReadings * s.attitudes.size();
  if (i >= readings + 3) return fmt::format("systematic_term_{}", i - readings - 3);
  if (i >= readings) return reliability::observation_names()[reliability::kReadings + i - readings];
  const std::string& name = reliability::observation_names()[i % reliability::kReadings];
  return s.attitudes.size() > 1 ? fmt::format("{}_{}", name, i / reliability::kReadings) : name;
}

}  // namespace

std::vector<compare::ComparisonRow> detection_rows(const Scenario& s, const analysis::GrossErrorPrediction& p,
                                                   const stats::Tally& tally) {
  const EventLayout layout{s.injected.size(), s.strategies.size()};
  const std::uint64_t runs = tally.trials - tally.failed;
  compare::VerdictRule alarms = s.verdict;
  alarms.margin = s.false_alarm_margin;
  std::vector<compare::ComparisonRow> rows;
  const auto rate = [&](const std::string& formulation, const std::string& quantity, std::size_t event,
                        double predicted, const compare::VerdictRule& rule) -> compare::ComparisonRow& {
    const std::uint64_t events = tally.counts.empty() ? 0 : tally.counts[event];
    return rows.emplace_back(
        compare::labelled(formulation, compare::compare_rate(quantity, events, runs, predicted, rule, tally.trials)));
  };

  // What linear theory does not control at the true attitude has a test at the trials' own.
  for (std::size_t k = 0; k < s.injected.size(); ++k)
    rate("design", "false_alarm_" + s.injected[k].label, layout.false_alarm(k), p.two_sided_alpha, alarms);
  const double confidence = s.verdict.interval_confidence(tally.moments.count);
  compare::Estimate share = compare::mean_estimate(tally.moments, 0, confidence);
  if (tally.moments.count > 1)  // a share: its interval must not leave [0, 1]
    share.interval = stats::share_interval(share.value, tally.moments.variance(0), tally.moments.count, confidence);
  compare::ComparisonRow mean = compare::compare_value("false_alarm_mean", "1", share, p.two_sided_alpha, alarms,
                                                       tally.trials, tally.moments.count);
  mean.formulation = "design";
  mean.note = tally.moments.count > 1 ? "mean over all observations that can be tested" : "";
  rows.push_back(mean);
  rate("design", "false_alarm_any", layout.false_alarm_any(), p.false_alarm_any, alarms);
  compare::ComparisonRow& general =
      rate("design", "false_alarm_general", layout.false_alarm_general(), p.general.alpha, alarms);
  general.note +=
      fmt::format("{}chi2 above {:.4f}, level by the B-method", general.note.empty() ? "" : "; ", p.general.critical);

  for (const auto& [formulation, shift] : {std::pair{"linear", &p.linear}, std::pair{"nonlinear", &p.nonlinear}}) {
    if (s.injected.empty()) break;
    const bool linear = shift == &p.linear;
    for (std::size_t k = 0; k < s.injected.size(); ++k)
      rate(formulation, "detection_" + s.injected[k].label, layout.detection(k),
           analysis::single_test_power(p, *shift, k, s.pope), s.verdict);
    rate(formulation, "detection_any", layout.detection_any(), linear ? p.linear_any : p.any, s.verdict);
    rate(formulation, "detection_general", layout.detection_general(),
         std::isnan(shift->omega) ? kNaN
                                  : reliability::chi_squared_power(p.redundancy, shift->omega, p.general.critical),
         s.verdict);
  }

  for (std::size_t k = 0; k < s.strategies.size() && !s.injected.empty(); ++k)
    for (std::size_t o = 0; o < kOutcomes; ++o) {
      const auto outcome = static_cast<SnoopingOutcome>(o);
      double predicted = kNaN;
      if (s.strategies[k] == SnoopingStrategy::single && s.injected.size() == 1 && !std::isnan(p.any)) {
        const bool known = !std::isnan(p.identified);
        if (outcome == SnoopingOutcome::identified && known) predicted = p.in_group ? 0 : if_large(p.identified);
        if (outcome == SnoopingOutcome::group && known)
          predicted = p.in_group ? if_large(p.identified) : p.may_be_tied ? kNaN : 0;
        if (outcome == SnoopingOutcome::partly) predicted = 0;
        if (outcome == SnoopingOutcome::wrong) predicted = if_large(p.any - p.identified);
        if (outcome == SnoopingOutcome::missed) predicted = if_large(1 - p.any);
      }
      rate(strategy_names()[static_cast<std::size_t>(s.strategies[k])], outcome_names()[o], layout.outcome(k, o),
           predicted, s.verdict);
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
