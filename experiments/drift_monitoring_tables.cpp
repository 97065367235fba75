/// Tables of drift_monitoring besides metrics and claims (docs/results-format.md).
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drift_monitoring.h"
#include "stats/order_statistics.h"
#include "study/table_writer.h"

namespace surveymc {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Writes value and interval of a probability.
void write_share(TableWriter& w, std::uint64_t count, std::uint64_t trials, double confidence) {
  if (trials == 0) {
    w << kNaN << kNaN << kNaN;
    return;
  }
  const Interval ci = binomial_interval(count, trials, confidence);
  w << static_cast<double>(count) / static_cast<double>(trials) << ci.lo << ci.hi;
}

/// Events per hour of exposure, with the exact interval of a Poisson count.
void write_rate(TableWriter& w, std::uint64_t count, double hours, double confidence) {
  const double n = static_cast<double>(count), tail = (1 - confidence) / 2;
  w << n / hours << (count == 0 ? 0 : chi_squared_quantile(2 * n, tail) / 2 / hours)
    << chi_squared_quantile(2 * n + 2, 1 - tail) / 2 / hours;
}

void add_counts(Table& t) {
  t.columns.push_back(count_column("trials", "realisations"));
  t.columns.push_back(count_column("failed", "realisations without a result"));
}
void write_counts(TableWriter& w, const Outcomes& o) { w << static_cast<std::int64_t>(o.trials()) << std::int64_t{0}; }

template <class Each>
void for_methods_and_sensors(const DriftScenario& s, Each each) {
  for (std::size_t m = 0; m < s.methods.size(); ++m)
    for (std::size_t j = 0; j < s.data.sensors.size(); ++j) each(m, j);
}

}  // namespace

Table alarms_table(const DriftScenario& s, const Outcomes& o) {
  const double confidence = s.verdict.confidence;
  Table t{"alarms", "alarms of every sensor; the first realisation, and all" + at_confidence(confidence)};
  t.columns = {word_column("architecture", "monitor, or test on the residual of AAKR"),
               word_column("sensor", "whose alarms"),
               number_column("amplitude_z", "1", "drift at the end of the test, training sd; 0: healthy"),
               number_column("first_alarm_h", "h", "first realisation: first alarm, hours into the test"),
               number_column("alarms", "1", "first realisation: how many"),
               word_column("judgement", "first realisation: correct, false, early (before the drift), missed or none")};
  add_with_interval(t, "p_alarm", "1", "share of realisations with any alarm");
  add_with_interval(t, "p_false_alarm", "1", "share with an alarm of the healthy sensor, or before its drift");
  add_with_interval(t, "p_alarm_without_drift", "1", "share with an alarm if no sensor drifts");
  add_with_interval(t, "alarms_per_h_without_drift", "1/h", "first alarms per hour until then, if no sensor drifts");
  add_counts(t);
  TableWriter w(std::move(t));
  const double end = s.data.test_end_h;
  for_methods_and_sensors(s, [&](std::size_t m, std::size_t j) {
    const double amplitude = s.amplitude[static_cast<Eigen::Index>(j)];
    const auto value = [&](std::size_t trial, OutcomeLayout::Alarm what) { return o(trial, o.at.alarm(m, j, what)); };
    std::uint64_t any = 0, wrong = 0, without = 0;
    double exposure = 0;
    for (std::size_t i = 0; i < o.trials(); ++i) {
      const double first = value(i, OutcomeLayout::first), quiet = value(i, OutcomeLayout::first_without_drift);
      any += !std::isnan(first);
      wrong += !std::isnan(first) && (amplitude == 0 || first < s.start_h);
      without += !std::isnan(quiet);
      exposure += std::isnan(quiet) ? end : quiet;
    }
    const double first = value(0, OutcomeLayout::first);
    const char* judgement = std::isnan(first)   ? (amplitude == 0 ? "none" : "missed")
                            : amplitude == 0    ? "false"
                            : first < s.start_h ? "early"
                                                : "correct";
    w << s.methods[m].name << s.data.sensors[j] << amplitude << first << value(0, OutcomeLayout::count)
      << std::string(judgement);
    write_share(w, any, o.trials(), confidence);
    write_share(w, wrong, o.trials(), confidence);
    write_share(w, without, o.trials(), confidence);
    write_rate(w, without, exposure, confidence);
    write_counts(w, o);
  });
  return w.take();
}

Table delay_table(const DriftScenario& s, const Outcomes& o) {
  const double confidence = s.verdict.confidence;
  Table t{"delay", "hours from the start of a drift to the first alarm of its sensor; a miss counts as infinite" +
                       at_confidence(confidence)};
  t.columns = {word_column("architecture", "monitor, or test on the residual of AAKR"),
               word_column("sensor", "that drifts"),
               number_column("amplitude_z", "1", "drift at the end of the test, training sd")};
  add_with_interval(t, "p_miss", "1", "share of realisations without an alarm after the drift began");
  t.columns.push_back(number_column("delay_q05_h", "h", "quantile of the delay, 5 %"));
  add_with_interval(t, "delay_q50_h", "h", "median of the delay");
  t.columns.push_back(number_column("delay_q95_h", "h", "quantile of the delay, 95 %"));
  t.columns.push_back(number_column("drift_at_q50_z", "1", "size of the drift at the median delay"));
  add_counts(t);
  TableWriter w(std::move(t));
  const double ramp = s.data.test_end_h - s.start_h;
  for_methods_and_sensors(s, [&](std::size_t m, std::size_t j) {
    const double amplitude = s.amplitude[static_cast<Eigen::Index>(j)];
    if (amplitude == 0) return;
    std::vector<double> delays = o.all(o.at.alarm(m, j, OutcomeLayout::first_after_start));
    std::uint64_t missed = 0;
    for (double& d : delays) {
      missed += std::isnan(d);
      d = std::isnan(d) ? std::numeric_limits<double>::infinity() : d - s.start_h;
    }
    std::sort(delays.begin(), delays.end());
    const double median = sorted_quantile(delays, 0.5);
    w << s.methods[m].name << s.data.sensors[j] << amplitude;
    write_share(w, missed, o.trials(), confidence);
    const Interval ci = median_interval(delays, confidence);
    w << sorted_quantile(delays, 0.05) << median << ci.lo << ci.hi << sorted_quantile(delays, 0.95)
      << (std::isfinite(median) ? amplitude * median / ramp : kNaN);
    write_counts(w, o);
  });
  return w.take();
}

Table blame_table(const DriftScenario& s, const Outcomes& o) {
  Table t{"blame", "realisations in which a healthy sensor raised an alarm" + at_confidence(s.verdict.confidence)};
  t.columns = {word_column("architecture", "monitor, or test on the residual of AAKR")};
  add_with_interval(t, "p_healthy_blamed", "1", "share of realisations with an alarm of any healthy sensor");
  add_with_interval(t, "p_all_found", "1", "share of realisations in which every drift was found");
  add_counts(t);
  TableWriter w(std::move(t));
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    std::uint64_t blamed = 0, found = 0, healthy = 0;
    for (std::size_t i = 0; i < o.trials(); ++i) {
      bool blame = false, all = true;
      for (std::size_t j = 0; j < s.data.sensors.size(); ++j) {
        const bool drifts = s.drifts(static_cast<Eigen::Index>(j));
        healthy += !drifts;
        if (drifts)
          all = all && !std::isnan(o(i, o.at.alarm(m, j, OutcomeLayout::first_after_start)));
        else
          blame = blame || !std::isnan(o(i, o.at.alarm(m, j, OutcomeLayout::first)));
      }
      blamed += blame;
      found += all;
    }
    const bool any_drifts = healthy < o.trials() * s.data.sensors.size();
    w << s.methods[m].name;
    write_share(w, blamed, healthy > 0 ? o.trials() : 0, s.verdict.confidence);
    write_share(w, found, any_drifts ? o.trials() : 0, s.verdict.confidence);
    write_counts(w, o);
  }
  return w.take();
}

Table model_table(const DriftScenario& s, const TrainedModel& m) {
  Table t{"model", "the model of the first realisation, for [model] file: scaling in the sensors' units, memory in z"};
  t.columns = {word_column("item", "mean, sd, bandwidth (z), then memory vectors (z)")};
  for (std::size_t j = 0; j < s.data.sensors.size(); ++j)
    t.columns.push_back(number_column(s.data.sensors[j], s.data.units[j], "sensor"));
  TableWriter w(std::move(t));
  const auto put = [&](const char* item, const Eigen::RowVectorXd& x) {
    w << std::string(item);
    for (const double v : x) w << v;
  };
  put("mean", m.scaling.mean);
  put("sd", m.scaling.sd);
  put("bandwidth", Eigen::RowVectorXd::Constant(s.sensors(), m.bandwidth));
  for (Eigen::Index i = 0; i < m.memory.rows(); ++i) put("memory", m.memory.row(i));
  return w.take();
}

Table bandwidth_table(const DriftScenario& s) {
  Table t{"bandwidth", "cross-validation of the kernel's bandwidth on the training data of the first realisation"};
  t.columns = {number_column("bandwidth_z", "1", "h"),
               number_column("mse_measured_z2", "1", "mean square error against the readings left out"),
               number_column("mse_truth_z2", "1", "the same against readings without noise, where they are known"),
               count_column("chosen", "1: this one is used")};
  TableWriter w(std::move(t));
  for (const BandwidthScore& b : s.searched)
    w << b.bandwidth << b.mse_measured << b.mse_truth << static_cast<std::int64_t>(b.bandwidth == s.bandwidth);
  return w.take();
}

Table data_quality_table(const MonitoringData& d) {
  const SensorQuality& found = d.file->found;
  Table t{"data_quality", "what was wrong with the rows of the file"};
  t.columns = {word_column("finding", "kind of defect, or gap"), count_column("rows", "how many rows have it"),
               word_column("action", "what was done"), word_column("lines", "the first ten lines of the file")};
  TableWriter w(std::move(t));
  const auto put = [&](const std::string& kind, std::uint64_t rows, const std::string& action,
                       const std::vector<std::int64_t>& lines = {}) {
    w << kind << static_cast<std::int64_t>(rows) << (rows > 0 ? action : "")
      << fmt::format("{}", fmt::join(lines, " "));
  };
  for (int i = 0; i < kRowDefects; ++i)
    put(name(static_cast<RowDefect>(i)), found.defects[i].rows, "rows left out", found.defects[i].lines);
  put("gap", found.gaps.rows, "kept, time goes on", found.gaps.lines);
  put("good_rows", found.good_rows, "used");
  const auto trained = static_cast<std::uint64_t>(d.training.rows());
  put("training_rows", trained,
      d.thinned > 1 ? fmt::format("of {}: every {}th, and the largest and smallest of each sensor", d.train, d.thinned)
                    : "used");
  put("monitored_rows", static_cast<std::uint64_t>(d.tested()), "used");
  return w.take();
}

}  // namespace surveymc
