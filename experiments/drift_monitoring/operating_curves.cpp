/// Calibration of the baselines of drift_monitoring to the false alarms of the SPRT, and operating curves.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/error.h"
#include "base/units.h"
#include "drift_monitoring/study.h"

namespace surveymc::studies::drift_monitoring {
namespace {

/// Calibration takes realisations from here on; a run has at most 10^6.
constexpr std::uint64_t kFirstCalibrationTrial = std::uint64_t{1} << 40;

/// One fault-free realisation, over all sensors: whether the SPRT raised an alarm, the largest CUSUM and residual.
struct Quiet {
  bool alarm = false;
  double cusum = 0, residual = 0;
};

Quiet monitor_quiet(const Scenario& s, std::uint64_t trial) {
  const monitoring::Samples simulated = s.realisation(trial);
  const TrainedModel model = train_model(s, simulated.topRows(s.data.train));
  const monitoring::Aakr aakr(model.memory, model.bandwidth);
  monitoring::MonitorStream monitor(monitoring::Architecture::aakr_sprt, aakr, s.filter, false);
  monitoring::CusumOptions endless = s.cusum;
  endless.threshold = kInfinity;
  std::vector<monitoring::Sprt> sprt(s.data.sensors.size(), monitoring::Sprt(s.sprt));
  std::vector<monitoring::Cusum> cusum(s.data.sensors.size(), monitoring::Cusum(endless));
  Quiet q;
  for_each_block(s, simulated, [&](const ReadingBlock& in) {
    const monitoring::Samples residual = monitor.next(model.scaling.to_z(in.readings)).signal;
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

/// What the fault-free alarms decide.
struct Calibration {
  std::uint64_t alarms = 0;
  double cusum = 0, residual = 0;  // thresholds, z
};

/// `s` has data, model, bandwidth, test and allowance.
Calibration calibration_of(const Scenario& s, const std::atomic<bool>* stop) {
  Calibration out;
  std::vector<double> cusum, residual;
  for (std::uint64_t i = 0; i < s.calibration_trials; ++i) {
    if (stop && *stop) throw Interrupted("stopped before the baselines were calibrated");
    const Quiet q = monitor_quiet(s, kFirstCalibrationTrial + i);
    out.alarms += q.alarm;
    cusum.push_back(q.cusum);
    residual.push_back(q.residual);
  }
  out.cusum = threshold_for(cusum, out.alarms);
  out.residual = threshold_for(residual, out.alarms);
  return out;
}

/// All that it depends on where the model is trained in every realisation.
struct CalibrationInput {
  ExactSamples samples;
  double sample_s, noise_to_signal;
  Eigen::Index train, memory_vectors;
  double bandwidth;
  monitoring::SprtOptions sprt;
  monitoring::CusumOptions cusum;
  std::uint64_t trials;
  random::StudySeed seed;
  bool operator==(const CalibrationInput&) const = default;
};

Calibration calibrate(const CalibrationInput& in, const std::atomic<bool>* stop) {
  Scenario s;
  s.seed = in.seed;
  s.data.sensors.resize(static_cast<std::size_t>((*in.samples).cols()));
  s.data.sample_s = in.sample_s;
  s.data.noise_to_signal = in.noise_to_signal;
  s.data.rows = (*in.samples).rows();
  s.data.train = in.train;
  set_samples(s.data, *in.samples);
  s.memory_vectors = in.memory_vectors;
  s.bandwidth = in.bandwidth;
  s.sprt = in.sprt;
  s.cusum = in.cusum;
  s.calibration_trials = in.trials;
  return calibration_of(s, stop);
}

}  // namespace

void calibrate_baselines(Scenario& s, const montecarlo::RunOptions& options) {
  if (s.calibration_trials == 0 || s.architectures.front() != monitoring::Architecture::aakr_sprt) return;
  Calibration found;
  if (s.model) {
    found = calibration_of(s, options.stop);
  } else {
    const CalibrationInput in{simulated_samples(s.data, options),
                              s.data.sample_s,
                              s.data.noise_to_signal,
                              s.data.train,
                              s.memory_vectors,
                              s.bandwidth,
                              s.sprt,
                              s.cusum,
                              s.calibration_trials,
                              s.seed};
    found = *shared_work(options.shared, in, calibrate, in.samples.bytes(), options.stop);
  }
  s.calibration_alarms = found.alarms;
  s.cusum.threshold = found.cusum;
  s.threshold = found.residual;
  for (AlarmMethod& m : s.methods) {
    if (m.test == AlarmMethod::Test::cusum) m.setting = s.cusum.threshold;
    if (m.test == AlarmMethod::Test::threshold) m.setting = s.threshold;
  }
}

store::Table baselines_table(const Scenario& s) {
  compare::TableRows t(
      "baselines", "settings of the methods; with calibration, baselines have as many fault-free alarms as AAKR-SPRT");
  compare::write_rows(t, s.methods, [&](const AlarmMethod& m) {
    const bool counted = m.name != monitoring::name(monitoring::Architecture::aakr_kf_sprt);
    t.word("architecture", "monitor, or test on the residual of AAKR", m.name);
    t.word("setting", "key of the config", setting_key(m));
    t.number("value_z", "1", "as used, z", m.setting);
    t.count("calibration_trials", "fault-free realisations for it; 0: as given", counted ? s.calibration_trials : 0);
    t.count("calibration_alarms", "of them, those with an alarm of any sensor", counted ? s.calibration_alarms : 0);
  });
  return t.take();
}

/// One row: a method at a setting, and a sensor that drifts.
struct OperatingPoint {
  AlarmMethod method;
  std::string sensor;
  std::uint64_t quiet = 0, blamed = 0;
  Delays delays{{0.0}, 0};
};

store::Table operating_table(const Scenario& s, const Outcomes& o) {
  const double confidence = s.verdict.confidence;
  const std::size_t p = s.data.sensors.size();
  std::vector<OperatingPoint> points;
  for (std::size_t m = s.methods.size(); m < s.method_count(); ++m) {
    std::uint64_t quiet = 0;
    for (std::size_t i = 0; i < o.trials(); ++i) {
      bool alarm = false;
      for (std::size_t j = 0; j < p; ++j)
        alarm = alarm || !std::isnan(o(i, o.at.alarm(m, j, OutcomeLayout::first_without_drift)));
      quiet += alarm;
    }
    for (std::size_t j = 0; j < p; ++j)
      if (s.drifts(static_cast<Eigen::Index>(j)))
        points.push_back({s.method(m), s.data.sensors[j], quiet, count_blames(s, o, m), delays_of(s, o, m, j)});
  }
  compare::TableRows t("operating", "delay against false alarms at other settings; a miss counts as infinite" +
                                        compare::at_confidence(confidence));
  compare::write_rows(t, points, [&](const OperatingPoint& x) {
    t.word("architecture", "monitor, or test on the residual of AAKR", x.method.name);
    t.word("setting", "key of the config", setting_key(x.method));
    t.number("value_z", "1", "its value, z", x.method.setting);
    t.word("sensor", "that drifts", x.sensor);
    t.share("p_alarm_without_drift", "share of realisations with an alarm of any sensor, none drifting", x.quiet,
            o.trials(), confidence);
    t.share("p_healthy_blamed", "share with an alarm of any healthy sensor, others drifting", x.blamed,
            s.any_healthy() ? o.trials() : 0, confidence);
    t.share("p_miss", "share without an alarm of this sensor after its drift began", x.delays.missed, o.trials(),
            confidence);
    write_delays(t, x.delays, confidence);
    write_counts(t, o);
  });
  return t.take();
}

}  // namespace surveymc::studies::drift_monitoring
