/// Tables of drift_monitoring besides metrics and claims (docs/results-format.md).
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/units.h"
#include "compare/table_rows.h"
#include "drift_monitoring/study.h"
#include "stats/order_statistics.h"

namespace surveymc::studies::drift_monitoring {
namespace {

/// Events per hour of exposure, with the exact interval of a Poisson count.
void write_rate(compare::TableRows& t, const char* name, const char* meaning, std::uint64_t count, double hours,
                double confidence) {
  const double n = static_cast<double>(count), tail = (1 - confidence) / 2;
  t.estimate(name, "1/h", meaning, n / hours,
             {count == 0 ? 0 : stats::chi_squared_quantile(2 * n, tail) / 2 / hours,
              stats::chi_squared_quantile(2 * n + 2, 1 - tail) / 2 / hours});
}

template <class Each>
void for_methods_and_sensors(const Scenario& s, Each each) {
  for (std::size_t m = 0; m < s.methods.size(); ++m)
    for (std::size_t j = 0; j < s.data.sensors.size(); ++j) each(m, j);
}

}  // namespace

void write_counts(compare::TableRows& t, const Outcomes& o) {
  t.count("trials", "realisations", o.trials());
  t.count("failed", "realisations without a result", 0);
}

Delays delays_of(const Scenario& s, const Outcomes& o, std::size_t method, std::size_t sensor) {
  Delays d;
  d.sorted = o.all(o.at.alarm(method, sensor, OutcomeLayout::first_after_start));
  for (double& x : d.sorted) {
    d.missed += std::isnan(x);
    x = std::isnan(x) ? kInfinity : x - s.start_h;
  }
  std::sort(d.sorted.begin(), d.sorted.end());
  return d;
}

std::uint64_t count_blames(const Scenario& s, const Outcomes& o, std::size_t method) {
  std::uint64_t count = 0;
  for (std::size_t t = 0; t < o.trials(); ++t) {
    bool blame = false;
    for (std::size_t j = 0; j < s.data.sensors.size(); ++j)
      blame = blame || (!s.drifts(static_cast<Eigen::Index>(j)) &&
                        !std::isnan(o(t, o.at.alarm(method, j, OutcomeLayout::first))));
    count += blame;
  }
  return count;
}

void write_delays(compare::TableRows& t, const Delays& d, double confidence) {
  t.number("delay_q05_h", "h", "quantile of the delay, 5 %", stats::sorted_quantile(d.sorted, 0.05));
  t.estimate("delay_q50_h", "h", "median of the delay", stats::sorted_quantile(d.sorted, 0.5),
             stats::median_interval(d.sorted, confidence));
  t.number("delay_q95_h", "h", "quantile of the delay, 95 %", stats::sorted_quantile(d.sorted, 0.95));
}

store::Table alarms_table(const Scenario& s, const Outcomes& o) {
  const double confidence = s.verdict.confidence;
  compare::TableRows t("alarms",
                       "alarms of every sensor; the first realisation, and all" + compare::at_confidence(confidence));
  // Hours without samples (gaps of a file) are not monitored.
  const double sample_h = s.data.simulated() ? s.data.sample_s / 3600 : s.data.file->found.median_step_h;
  for_methods_and_sensors(s, [&](std::size_t m, std::size_t j) {
    const double amplitude = s.amplitude[static_cast<Eigen::Index>(j)];
    const auto value = [&](std::size_t trial, OutcomeLayout::Alarm what) { return o(trial, o.at.alarm(m, j, what)); };
    std::uint64_t any = 0, wrong = 0, without = 0;
    double samples = 0;
    for (std::size_t i = 0; i < o.trials(); ++i) {
      const double first = value(i, OutcomeLayout::first);
      any += !std::isnan(first);
      wrong += !std::isnan(first) && (amplitude == 0 || first < s.start_h);
      without += !std::isnan(value(i, OutcomeLayout::first_without_drift));
      samples += value(i, OutcomeLayout::samples_without_drift);
    }
    const double first = value(0, OutcomeLayout::first);
    t.word("architecture", "monitor, or test on the residual of AAKR", s.methods[m].name);
    t.word("sensor", "whose alarms", s.data.sensors[j]);
    t.number("amplitude_z", "1", "drift at the end of the test, training sd; 0: healthy", amplitude);
    t.number("first_alarm_h", "h", "first realisation: first alarm, hours into the test", first);
    t.number("alarms", "1", "first realisation: how many", value(0, OutcomeLayout::count));
    t.word("judgement", "first realisation: correct, false, early (before the drift), missed or none",
           std::isnan(first)   ? (amplitude == 0 ? "none" : "missed")
           : amplitude == 0    ? "false"
           : first < s.start_h ? "early"
                               : "correct");
    t.share("p_alarm", "share of realisations with any alarm", any, o.trials(), confidence);
    t.share("p_false_alarm", "share with an alarm of the healthy sensor, or before its drift", wrong, o.trials(),
            confidence);
    t.share("p_alarm_without_drift", "share with an alarm if no sensor drifts", without, o.trials(), confidence);
    write_rate(t, "alarms_per_h_without_drift", "first alarms per monitored hour until then, if no sensor drifts",
               without, samples * sample_h, confidence);
    write_counts(t, o);
  });
  return t.take();
}

store::Table delay_table(const Scenario& s, const Outcomes& o) {
  const double confidence = s.verdict.confidence, ramp = s.data.test_end_h - s.start_h;
  compare::TableRows t("delay",
                       "hours from the start of a drift to the first alarm of its sensor; a miss counts as infinite" +
                           compare::at_confidence(confidence));
  for_methods_and_sensors(s, [&](std::size_t m, std::size_t j) {
    const double amplitude = s.amplitude[static_cast<Eigen::Index>(j)];
    if (amplitude == 0 && s.any_drifts()) return;
    const Delays d = delays_of(s, o, m, j);
    const double median = stats::sorted_quantile(d.sorted, 0.5);
    t.word("architecture", "monitor, or test on the residual of AAKR", s.methods[m].name);
    t.word("sensor", "that drifts", s.data.sensors[j]);
    t.number("amplitude_z", "1", "drift at the end of the test, training sd", amplitude);
    t.share("p_miss", "share of realisations without an alarm after the drift began", d.missed, o.trials(), confidence);
    write_delays(t, d, confidence);
    t.number("drift_at_q50_z", "1", "size of the drift at the median delay",
             std::isfinite(median) ? amplitude * median / ramp : kNaN);
    write_counts(t, o);
  });
  if (!s.any_drifts()) t.drop_rows();
  return t.take();
}

store::Table blame_table(const Scenario& s, const Outcomes& o) {
  compare::TableRows t(
      "blame", "realisations in which a healthy sensor raised an alarm" + compare::at_confidence(s.verdict.confidence));
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    std::uint64_t found = 0;
    for (std::size_t i = 0; i < o.trials(); ++i) {
      bool all = true;
      for (std::size_t j = 0; j < s.data.sensors.size(); ++j)
        if (s.drifts(static_cast<Eigen::Index>(j)))
          all = all && !std::isnan(o(i, o.at.alarm(m, j, OutcomeLayout::first_after_start)));
      found += all;
    }
    t.word("architecture", "monitor, or test on the residual of AAKR", s.methods[m].name);
    t.share("p_healthy_blamed", "share of realisations with an alarm of any healthy sensor", count_blames(s, o, m),
            s.any_healthy() ? o.trials() : 0, s.verdict.confidence);
    t.share("p_all_found", "share of realisations in which every drift was found", found,
            s.any_drifts() ? o.trials() : 0, s.verdict.confidence);
    write_counts(t, o);
  }
  return t.take();
}

store::Table model_table(const Scenario& s, const TrainedModel& m) {
  compare::TableRows t(
      "model", "the model of the first realisation, for [model] file: scaling in the sensors' units, memory in z");
  const auto put = [&](const char* item, const Eigen::RowVectorXd& x) {
    t.word("item", "mean, sd, bandwidth (z), then memory vectors (z)", item);
    for (std::size_t j = 0; j < s.data.sensors.size(); ++j)
      t.number(s.data.sensors[j], s.data.units[j], "sensor", x[static_cast<Eigen::Index>(j)]);
  };
  put("mean", m.scaling.mean);
  put("sd", m.scaling.sd);
  put("bandwidth", Eigen::RowVectorXd::Constant(s.sensors(), m.bandwidth));
  for (Eigen::Index i = 0; i < m.memory.rows(); ++i) put("memory", m.memory.row(i));
  return t.take();
}

store::Table bandwidth_table(const Scenario& s) {
  compare::TableRows t("bandwidth",
                       "cross-validation of the kernel's bandwidth on the training data of the first realisation");
  compare::write_rows(t, s.searched, [&](const monitoring::BandwidthScore& b) {
    t.number("bandwidth_z", "1", "h", b.bandwidth);
    t.number("mse_measured_z2", "1", "mean square error against the readings left out", b.mse_measured);
    t.number("mse_truth_z2", "1", "the same against readings without noise, where they are known", b.mse_truth);
    t.count("chosen", "1: this one is used", b.bandwidth == s.bandwidth);
  });
  return t.take();
}

store::Table data_quality_table(const MonitoringData& d) {
  const config::SensorQuality& found = d.file->found;
  compare::TableRows t("data_quality", "what was wrong with the rows of the file");
  const auto put = [&](const std::string& kind, std::uint64_t rows, const std::string& action,
                       const std::vector<std::int64_t>& lines = {}) {
    t.word("finding", "kind of defect, or gap", kind);
    t.count("rows", "how many rows have it", rows);
    t.word("action", "what was done", rows > 0 ? action : "");
    t.word("lines", "the first ten lines of the file", fmt::format("{}", fmt::join(lines, " ")));
  };
  for (int i = 0; i < config::kRowDefects; ++i)
    put(config::name(static_cast<config::RowDefect>(i)), found.defects[i].rows, "rows left out",
        found.defects[i].lines);
  put("gap", found.gaps.rows, "kept, time goes on", found.gaps.lines);
  put("good_rows", found.good_rows, "used");
  const auto trained = static_cast<std::uint64_t>(d.training.rows());
  put("training_rows", trained,
      d.thinned > 1 ? fmt::format("of {}: every {}th, and the largest and smallest of each sensor", d.train, d.thinned)
                    : "used");
  put("monitored_rows", static_cast<std::uint64_t>(d.tested()), "used");
  return t.take();
}

}  // namespace surveymc::studies::drift_monitoring
