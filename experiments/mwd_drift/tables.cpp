/// Tables of mwd_drift.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/units.h"
#include "compare/claims.h"
#include "compare/table_rows.h"
#include "monitoring/sprt_false_alarms.h"
#include "mwd_drift/study.h"
#include "stats/order_statistics.h"

namespace surveymc::studies::mwd_drift {
namespace {

constexpr const char* kSprt = "channel_sprt";
constexpr const char* kFilter = "bias_filter";
constexpr const char* kNoDrift = "no sensor drifts: every alarm is false";

using Value = Outcome::Value;

std::uint64_t alarms(const Outcomes& o, Value v) {
  std::uint64_t n = 0;
  for (std::size_t t = 0; t < o.trials(); ++t) n += o(t, v) >= 0;
  return n;
}

/// Wells in which there is a drift to find.
std::uint64_t drifting(const Scenario& s, const Outcomes& o) { return s.drifts() ? o.trials() : 0; }

/// Of these, those with an alarm once the drift has begun.
std::uint64_t detections(const Scenario& s, const Outcomes& o, Value v) { return s.drifts() ? alarms(o, v) : 0; }

std::uint64_t rightly_named(const Scenario& s, const Outcomes& o) {
  std::uint64_t n = 0;
  if (!s.drifts()) return n;
  for (std::size_t t = 0; t < o.trials(); ++t) n += static_cast<int>(o(t, Value::named)) == s.sensor;
  return n;
}

/// Stations from the start of the drift to the alarm, sorted; a miss is infinite.
std::vector<double> delays(const Scenario& s, const Outcomes& o, Value v) {
  std::vector<double> d;
  if (!s.drifts()) return d;
  for (std::size_t t = 0; t < o.trials(); ++t) d.push_back(o(t, v) >= 0 ? o(t, v) - s.from_station : kInfinity);
  std::sort(d.begin(), d.end());
  return d;
}

std::vector<double> all(const Outcomes& o, Value v) {
  std::vector<double> x;
  for (std::size_t t = 0; t < o.trials(); ++t) x.push_back(o(t, v));
  return x;
}

/// Mean over wells against the mean of a chi-squared variable.
compare::ComparisonRow mean_against(const std::string& quantity, const std::vector<double>& x, double expected,
                                    const Scenario& s, double margin) {
  compare::VerdictRule rule = s.verdict;
  rule.margin = margin;
  const compare::ComparisonRow found = compare::mean_row(kFilter, quantity, "1", x, s.verdict.confidence);
  compare::ComparisonRow row = compare::labelled(
      kFilter, compare::compare_value(quantity, "1", {found.monte_carlo, found.interval}, expected, rule, x.size()));
  row.note = std::isnan(row.monte_carlo) ? "" : "all six biases walk as the filter assumes";
  return row;
}

compare::ComparisonRow median_row(const char* formulation, const std::vector<double>& sorted, double confidence) {
  compare::ComparisonRow row = compare::empty_row(formulation, "delay_q50_stations", "1");
  if (sorted.empty()) return row;
  row.monte_carlo = stats::sorted_quantile(sorted, 0.5);
  row.interval = stats::median_interval(sorted, confidence);
  return row;
}

/// P(the SPRT of any channel has an alarm without drift), and how it comes about; NaN where it is not known to within
/// the margin of the verdict.
struct FalseAlarms {
  double probability;
  std::string note;
};
FalseAlarms predict_false_alarms(const Scenario& s) {
  const double one_side = monitoring::sprt_alarm_probability(s.sprt, 0, 1, s.stations).back();
  if (std::isnan(one_side))
    return {kNaN, "no prediction: sprt.shift_sd is too small for the integration between these bounds of the SPRT"};
  // Channels are independent: noise of a triad is alike on its axes, so that rows of the Jacobian are orthogonal in it.
  const auto any_of_three = [](double p) { return 1 - std::pow(1 - p, 3); };
  const monitoring::TwoSided channel = monitoring::two_sided_alarm_probability(one_side);
  const double least = any_of_three(channel.independent), most = any_of_three(channel.exclusive);
  if (least < (1 - s.verdict.margin) * most)
    return {kNaN,
            fmt::format("no prediction within the margin: from {:.4g} (the two sides of a channel independent) to "
                        "{:.4g} (exclusive)",
                        least, most)};
  return {least, "analytic: three channels, two sides each"};
}

/// What has no meaning where no sensor drifts.
bool is_of_drift(const std::string& quantity) {
  constexpr std::array kOfDrift{"p_detected",      "delay_q50_stations", "p_named",
                                "detects_no_less", "is_sooner",          "names_the_right_sensor"};
  return std::find(kOfDrift.begin(), kOfDrift.end(), quantity) != kOfDrift.end();
}

void write_counts(compare::TableRows& t, const Outcomes& o) {
  t.count("trials", "wells", o.trials());
  t.count("failed", "wells without a result", 0);
}

}  // namespace

std::vector<compare::ComparisonRow> comparison_rows(const Scenario& s, const Outcomes& o) {
  const std::uint64_t n = o.trials();
  const auto rate = [&](const char* formulation, const char* quantity, std::uint64_t count, std::uint64_t runs,
                        double predicted) {
    return compare::labelled(formulation, compare::compare_rate(quantity, count, runs, predicted, s.verdict, n));
  };
  const FalseAlarms predicted = predict_false_alarms(s);
  compare::ComparisonRow false_alarm =
      rate(kSprt, "p_alarm_without_drift", alarms(o, Value::sprt_without), n, predicted.probability);
  false_alarm.note += (false_alarm.note.empty() ? "" : "; ") + predicted.note;
  compare::ComparisonRow of_filter = rate(kFilter, "p_alarm_without_drift", alarms(o, Value::filter_without), n, kNaN);
  of_filter.note = "no closed form: made about as rare as that of the SPRT by alarm_sd";
  std::vector<compare::ComparisonRow> rows{
      mean_against("nis_mean", all(o, Value::nis_mean), 3, s, s.verdict.nees_margin),
      mean_against("nis_within_95", all(o, Value::nis_inside), 0.95, s, s.verdict.margin),
      mean_against("nees_mean", all(o, Value::nees_mean), 6, s, s.verdict.nees_margin),
      false_alarm,
      of_filter,
      rate(kSprt, "p_detected", detections(s, o, Value::sprt), drifting(s, o), kNaN),
      rate(kFilter, "p_detected", detections(s, o, Value::filter), drifting(s, o), kNaN),
      median_row(kSprt, delays(s, o, Value::sprt), s.verdict.confidence),
      median_row(kFilter, delays(s, o, Value::filter), s.verdict.confidence),
      rate(kFilter, "p_named", rightly_named(s, o), detections(s, o, Value::filter), kNaN)};
  for (compare::ComparisonRow& row : rows)
    if (!s.drifts() && is_of_drift(row.quantity)) row.note = kNoDrift;
  return rows;
}

std::vector<compare::ComparisonRow> claim_rows(const Scenario& s, const Outcomes& o) {
  const double confidence = s.verdict.confidence;
  const char* both = "bias_filter / channel_sprt";
  std::uint64_t filter_alone = 0, sprt_alone = 0, sooner = 0, decided = 0;
  for (std::size_t t = 0; t < o.trials(); ++t) {
    const double filter = o(t, Value::filter), sprt = o(t, Value::sprt);
    filter_alone += filter >= 0 && sprt < 0;
    sprt_alone += sprt >= 0 && filter < 0;
    const double f = filter >= 0 ? filter : s.stations, p = sprt >= 0 ? sprt : s.stations;
    sooner += f < p;
    decided += f != p;
  }
  compare::ComparisonRow more = compare::empty_row(both, "detects_no_less", "1");
  if (o.trials() > 0) {
    more.monte_carlo =
        (static_cast<double>(filter_alone) - static_cast<double>(sprt_alone)) / static_cast<double>(o.trials());
    more.interval = stats::paired_difference_interval(filter_alone, sprt_alone, o.trials(), confidence);
  }
  const auto share = [&](const char* formulation, const char* quantity, std::uint64_t count, std::uint64_t runs) {
    compare::ComparisonRow row =
        compare::labelled(formulation, compare::compare_rate(quantity, count, runs, kNaN, s.verdict, o.trials()));
    row.note.clear();
    return row;
  };
  std::vector<compare::ComparisonRow> rows{
      compare::judge_claim(more, -0.01, false, confidence, "share of wells found, less that of the SPRT: above -1 %"),
      compare::judge_claim(share(both, "is_sooner", sooner, decided), 0.5, false, confidence,
                           "in more than half of the wells in which one is sooner"),
      compare::judge_claim(share(kFilter, "names_the_right_sensor", rightly_named(s, o), alarms(o, Value::filter)),
                           0.99, false, confidence, "in more than 99 % of its alarms"),
      compare::judge_claim(share(kSprt, "false_alarms_are_rare", alarms(o, Value::sprt_without), o.trials()), 0.01,
                           true, confidence, "in less than 1 % of wells without drift"),
      compare::judge_claim(share(kFilter, "false_alarms_are_rare", alarms(o, Value::filter_without), o.trials()), 0.01,
                           true, confidence, "in less than 1 % of wells without drift")};
  if (s.drifts()) return rows;
  // Every alarm is false here: there is nothing to find sooner, and no right sensor to name.
  for (compare::ComparisonRow& row : rows) {
    if (!is_of_drift(row.quantity)) continue;
    row = compare::empty_row(row.formulation, row.quantity, row.unit);
    row.note = kNoDrift;
  }
  return rows;
}

store::Table detection_table(const Scenario& s, const Outcomes& o) {
  const double confidence = s.verdict.confidence;
  compare::TableRows t("detection", "drift of one sensor along a survey" + compare::at_confidence(confidence));
  for (const bool filter : {false, true}) {
    const Value with = filter ? Value::filter : Value::sprt,
                without = filter ? Value::filter_without : Value::sprt_without;
    const std::vector<double> sorted = delays(s, o, with);
    const auto delay = [&](double share) { return sorted.empty() ? kNaN : stats::sorted_quantile(sorted, share); };
    const std::uint64_t detected = detections(s, o, with);
    t.word("method", "channel_sprt or bias_filter", filter ? kFilter : kSprt);
    t.word("sensor", "that drifts", s.drifts() ? kSensors[static_cast<std::size_t>(s.sensor)] : "none");
    t.share("p_detected", "share of wells with an alarm once the drift has begun", detected, drifting(s, o),
            confidence);
    t.number("delay_q05_stations", "1", "stations from the start of the drift to the alarm, 5 %", delay(0.05));
    t.estimate("delay_q50_stations", "1", "the same, median; a miss is infinite", delay(0.5),
               sorted.empty() ? stats::Interval{kNaN, kNaN} : stats::median_interval(sorted, confidence));
    t.number("delay_q95_stations", "1", "the same, 95 %", delay(0.95));
    t.share("p_named", "share of these alarms that name the right sensor", rightly_named(s, o), filter ? detected : 0,
            confidence);
    t.share("p_alarm_without_drift", "share of wells with any alarm if no sensor drifts", alarms(o, without),
            o.trials(), confidence);
    write_counts(t, o);
  }
  return t.take();
}

store::Table alarm_curve_table(const Scenario& s, const Outcomes& o) {
  const double confidence = s.verdict.confidence;
  compare::TableRows t("alarm_curve",
                       "share of wells with an alarm up to a station" + compare::at_confidence(confidence));
  for (const bool filter : {false, true}) {
    const auto up_to = [&](Value v) {
      std::vector<std::uint64_t> n(static_cast<std::size_t>(s.stations), 0);
      for (std::size_t i = 0; i < o.trials(); ++i)
        if (o(i, v) >= 0) ++n[static_cast<std::size_t>(o(i, v))];
      for (std::size_t k = 1; k < n.size(); ++k) n[k] += n[k - 1];
      return n;
    };
    const auto with = up_to(filter ? Value::filter : Value::sprt),
               without = up_to(filter ? Value::filter_without : Value::sprt_without);
    for (int k = 0; k < s.stations; ++k) {
      const auto i = static_cast<std::size_t>(k);
      t.word("method", "channel_sprt or bias_filter", filter ? kFilter : kSprt);
      t.number("md_m", "m", "measured depth from the first station", k * s.spacing);
      t.number("drift_share", "1", "share of the drift that has come", s.ramp(k));
      t.share("p_alarm", "one sensor drifts; alarms before the drift begins do not count", with[i], o.trials(),
              confidence);
      t.share("p_alarm_without_drift", "no sensor drifts", without[i], o.trials(), confidence);
      write_counts(t, o);
    }
  }
  return t.take();
}

store::Table series_table(const Scenario& s) {
  compare::TableRows t("series",
                       "first well, with drift: channels in their sd, and the biases that the filter estimates");
  constexpr std::array<const char*, 3> kChannels{"gravity", "total_field", "dip"};
  const analysis::DriftRun run = analysis::drift_run(s, 0, analysis::SensorBias::ramp, true);
  for (int k = 0; k < s.stations; ++k) {
    const analysis::DriftingStation& at = run.stations[static_cast<std::size_t>(k)];
    t.number("md_m", "m", "measured depth from the first station", k * s.spacing);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::string name = kChannels[c];
      t.number(name + "_sd", "1", "channel less reference, over its sd without drift",
               at.channels[static_cast<Eigen::Index>(c)]);
      t.count("decision_" + name, "of the SPRT on this channel: 0, or the sign of the shift", at.sprt[c]);
    }
    for (int j = 0; j < 6; ++j) {
      const double size = j < 3 ? kMilliG : 1;
      const std::string unit = j < 3 ? "mg" : "nT", name = kSensors[static_cast<std::size_t>(j)] + ("_" + unit);
      t.number("bias_" + name, unit, "estimate", at.bias[j] / size);
      t.number("sd_" + name, unit, "of the estimate, one sigma", at.sd[j] / size);
      t.number("true_" + name, unit, "drift of the sensor", at.truth[j] / size);
    }
    t.word("named", "sensor that the filter's alarm names at this station; empty: no alarm",
           at.named < 0 ? "" : kSensors[static_cast<std::size_t>(at.named)]);
  }
  return t.take();
}

}  // namespace surveymc::studies::mwd_drift
