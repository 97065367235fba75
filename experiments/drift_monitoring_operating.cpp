/// Baselines of drift_monitoring made as rare in their false alarms as the SPRT, and operating curves.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/error.h"
#include "drift_monitoring.h"
#include "stats/order_statistics.h"
#include "study/table_writer.h"

namespace surveymc {
namespace {

/// Calibration takes realisations from here on; a run has at most 10^6.
constexpr std::uint64_t kFirstCalibrationTrial = std::uint64_t{1} << 40;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Of one fault-free realisation, over all sensors: whether the SPRT raised an alarm, the largest CUSUM and residual.
struct Quiet {
  bool alarm = false;
  double cusum = 0, residual = 0;
};

Quiet monitor_quiet(const DriftScenario& s, std::uint64_t trial) {
  const Samples simulated = s.realisation(trial);
  const TrainedModel model = train_model(s, simulated.topRows(s.data.train));
  const Aakr aakr(model.memory, model.bandwidth);
  MonitorStream monitor(Architecture::aakr_sprt, aakr, s.filter);
  CusumOptions endless = s.cusum;
  endless.threshold = kInfinity;
  std::vector<Sprt> sprt(s.data.sensors.size(), Sprt(s.sprt));
  std::vector<Cusum> cusum(s.data.sensors.size(), Cusum(endless));
  Quiet q;
  for_each_block(s, simulated, [&](const ReadingBlock& in) {
    const Samples residual = monitor.next(model.scaling.to_z(in.readings)).signal;
    for (Eigen::Index i = 0; i < residual.rows(); ++i)
      for (std::size_t j = 0; j < sprt.size(); ++j) {
        const double d = residual(i, static_cast<Eigen::Index>(j));
        q.alarm = sprt[j].update(d) != 0 || q.alarm;
        cusum[j].update(d);
        q.cusum = std::max(q.cusum, cusum[j].largest());
        q.residual = std::max(q.residual, std::abs(d));
      }
  });
  return q;
}

/// Just above all but the `alarms` largest of x.
double threshold_for(std::vector<double> x, std::uint64_t alarms) {
  std::sort(x.begin(), x.end(), std::greater<>());
  const double reached = x[std::min<std::size_t>(alarms, x.size() - 1)];
  return std::nextafter(std::max(reached, std::numeric_limits<double>::min()), kInfinity);
}

const char* setting_key(const AlarmMethod& m) {
  return m.test == AlarmMethod::Test::sprt    ? "sprt.shift_z"
         : m.test == AlarmMethod::Test::cusum ? "baselines.cusum_threshold_z"
                                              : "baselines.threshold_z";
}

void write_share(TableWriter& w, std::uint64_t count, std::uint64_t trials, double confidence) {
  if (trials == 0) {
    w << kNone << kNone << kNone;
    return;
  }
  const Interval ci = binomial_interval(count, trials, confidence);
  w << static_cast<double>(count) / static_cast<double>(trials) << ci.lo << ci.hi;
}

}  // namespace

void calibrate_baselines(DriftScenario& s, const std::atomic<bool>* stop) {
  if (s.calibration_trials == 0 || s.architectures.front() != Architecture::aakr_sprt) return;
  std::vector<double> cusum, residual;
  s.calibration_alarms = 0;
  for (std::uint64_t i = 0; i < s.calibration_trials; ++i) {
    if (stop && *stop) throw Interrupted("stopped before the baselines were calibrated");
    const Quiet q = monitor_quiet(s, kFirstCalibrationTrial + i);
    s.calibration_alarms += q.alarm;
    cusum.push_back(q.cusum);
    residual.push_back(q.residual);
  }
  s.cusum.threshold = threshold_for(cusum, s.calibration_alarms);
  s.threshold = threshold_for(residual, s.calibration_alarms);
  for (AlarmMethod& m : s.methods) {
    if (m.test == AlarmMethod::Test::cusum) m.setting = s.cusum.threshold;
    if (m.test == AlarmMethod::Test::threshold) m.setting = s.threshold;
  }
}

Table baselines_table(const DriftScenario& s) {
  Table t{"baselines",
          "settings of the methods; with calibration, baselines have as many fault-free alarms as AAKR-SPRT"};
  t.columns = {word_column("architecture", "monitor, or test on the residual of AAKR"),
               word_column("setting", "key of the config"), number_column("value_z", "1", "as used, z"),
               count_column("calibration_trials", "fault-free realisations for it; 0: as given"),
               count_column("calibration_alarms", "of them, those with an alarm of any sensor")};
  TableWriter w(std::move(t));
  for (const AlarmMethod& m : s.methods) {
    const bool counted = m.name != name(Architecture::aakr_kf_sprt);
    w << m.name << std::string(setting_key(m)) << m.setting
      << static_cast<std::int64_t>(counted ? s.calibration_trials : 0)
      << static_cast<std::int64_t>(counted ? s.calibration_alarms : 0);
  }
  return w.take();
}

Table operating_table(const DriftScenario& s, const Outcomes& o) {
  const double confidence = s.verdict.confidence;
  Table t{"operating",
          "delay against false alarms at other settings; a miss counts as infinite" + at_confidence(confidence)};
  t.columns = {word_column("architecture", "monitor, or test on the residual of AAKR"),
               word_column("setting", "key of the config"), number_column("value_z", "1", "its value, z"),
               word_column("sensor", "that drifts")};
  add_with_interval(t, "p_alarm_without_drift", "1",
                    "share of realisations with an alarm of any sensor, none drifting");
  add_with_interval(t, "p_healthy_blamed", "1", "share with an alarm of any healthy sensor, others drifting");
  add_with_interval(t, "p_miss", "1", "share without an alarm of this sensor after its drift began");
  t.columns.push_back(number_column("delay_q05_h", "h", "quantile of the delay, 5 %"));
  add_with_interval(t, "delay_q50_h", "h", "median of the delay");
  t.columns.push_back(number_column("delay_q95_h", "h", "quantile of the delay, 95 %"));
  t.columns.push_back(count_column("trials", "realisations"));
  t.columns.push_back(count_column("failed", "realisations without a result"));
  TableWriter w(std::move(t));
  const std::size_t p = s.data.sensors.size();
  for (std::size_t m = s.methods.size(); m < s.method_count(); ++m) {
    std::uint64_t quiet = 0, blamed = 0;
    bool any_healthy = false;
    for (std::size_t i = 0; i < o.trials(); ++i) {
      bool alarm = false, blame = false;
      for (std::size_t j = 0; j < p; ++j) {
        alarm = alarm || !std::isnan(o(i, o.at.alarm(m, j, OutcomeLayout::first_without_drift)));
        if (s.drifts(static_cast<Eigen::Index>(j))) continue;
        any_healthy = true;
        blame = blame || !std::isnan(o(i, o.at.alarm(m, j, OutcomeLayout::first)));
      }
      quiet += alarm;
      blamed += blame;
    }
    for (std::size_t j = 0; j < p; ++j) {
      if (!s.drifts(static_cast<Eigen::Index>(j))) continue;
      std::vector<double> delays = o.all(o.at.alarm(m, j, OutcomeLayout::first_after_start));
      std::uint64_t missed = 0;
      for (double& d : delays) {
        missed += std::isnan(d);
        d = std::isnan(d) ? kInfinity : d - s.start_h;
      }
      std::sort(delays.begin(), delays.end());
      w << s.method(m).name << std::string(setting_key(s.method(m))) << s.method(m).setting << s.data.sensors[j];
      write_share(w, quiet, o.trials(), confidence);
      write_share(w, blamed, any_healthy ? o.trials() : 0, confidence);
      write_share(w, missed, o.trials(), confidence);
      const Interval ci = median_interval(delays, confidence);
      w << sorted_quantile(delays, 0.05) << sorted_quantile(delays, 0.5) << ci.lo << ci.hi
        << sorted_quantile(delays, 0.95) << static_cast<std::int64_t>(o.trials()) << std::int64_t{0};
    }
  }
  return w.take();
}

}  // namespace surveymc
