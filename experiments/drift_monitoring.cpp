/// Study: do on-line calibration monitors find the sensors that drift, how soon, and do they blame healthy ones?
/// AAKR-SPRT and AAKR-KF-SPRT of Boechat, Moreno and Haramura, on a simulated gas-lift well or on a user's file.
///
///   truth -> noise (a realisation) -> scaling, memory (training) -> monitor without and with drift -> alarms, metrics
#include "drift_monitoring.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "experiments.h"
#include "monitoring/metrics.h"

namespace surveymc {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

TrainedModel train(const DriftScenario& s, const Samples& readings) {
  if (s.model) return *s.model;
  const Samples training = readings.topRows(s.data.train);
  TrainedModel m{fit_scaling(training), {}, s.bandwidth};
  const Samples z = m.scaling.to_z(training);
  m.memory = rows_of(z, select_memory(z, s.memory_vectors));
  return m;
}

class DriftMonitoring final : public StudyPoint {
 public:
  explicit DriftMonitoring(DriftScenario scenario) : s_(std::move(scenario)) {}

  std::uint64_t trials() const override { return s_.trials; }
  int block_trials() const override { return 4; }  // a realisation takes tens of milliseconds

  Tally run_block(TrialBlock block) const override {
    Tally tally;
    tally.trials = static_cast<std::uint64_t>(block.count);
    for (int i = 0; i < block.count; ++i) {
      const std::vector<double> row = outcome(s_, monitor(s_, block.first + static_cast<std::uint64_t>(i)));
      tally.samples.insert(tally.samples.end(), row.begin(), row.end());
    }
    return tally;
  }

  PointResult finish(const Tally& tally) const override {
    const Outcomes o(s_, tally.samples);
    const MonitoredRealisation shown = monitor(s_, 0);
    const std::string at = at_confidence(s_.verdict.confidence);
    PointResult r;
    std::vector<ComparisonRow> metrics = metric_rows(s_, o), claims = claim_rows(s_, o);
    s_.annotations.apply("metrics", metrics);
    s_.annotations.apply("claims", claims);
    r.tables = {
        comparison_table("metrics", "accuracy and sensitivity, means over realisations" + at, metrics, tally.trials, 0,
                         true),
        alarms_table(s_, o),
        delay_table(s_, o),
        blame_table(s_, o),
        comparison_table("claims", "what the source says of the two architectures" + at, claims, tally.trials, 0, true),
        model_table(s_, shown)};
    if (s_.series_every > 0) r.tables.push_back(series_table(s_, shown));
    if (!s_.searched.empty()) r.tables.push_back(bandwidth_table(s_));
    if (s_.data.found) r.tables.push_back(data_quality_table(*s_.data.found));
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const OutcomeLayout at(s_);
    const std::vector<double> row = outcome(s_, monitor(s_, trial));
    std::string text = fmt::format("realisation {}: first alarm, h into the test\n", trial);
    for (std::size_t m = 0; m < s_.methods.size(); ++m)
      for (std::size_t j = 0; j < s_.data.sensors.size(); ++j)
        text += fmt::format("{:<16} {:<12} {:.17g}\n", s_.methods[m].name, s_.data.sensors[j],
                            row[at.alarm(m, j, OutcomeLayout::first)]);
    return text;
  }

 private:
  DriftScenario s_;
};

double first_hour(const DriftScenario& s, const AlarmTrace& trace, double from_h) {
  for (std::size_t i = 0; i < trace.alarm.size(); ++i)
    if (const double t = s.data.test_h(static_cast<Eigen::Index>(i)); trace.alarm[i] != 0 && t >= from_h) return t;
  return kNone;
}

}  // namespace

MonitoredRealisation monitor(const DriftScenario& s, std::uint64_t trial) {
  const Samples all = s.realisation(trial);
  MonitoredRealisation r;
  r.model = train(s, all);
  r.readings = r.model.scaling.to_z(all.bottomRows(s.data.tested()));
  if (s.data.simulated) r.truth = r.model.scaling.to_z(s.data.readings.bottomRows(s.data.tested()));
  r.drift = s.drift();
  const Aakr aakr(r.model.memory, r.model.bandwidth);
  for (const Architecture a : s.architectures) {
    r.without.push_back(run_monitor(a, aakr, s.filter, r.readings));
    r.with.push_back(run_monitor(a, aakr, s.filter, r.readings + r.drift));
  }
  return r;
}

AlarmTrace alarms(const DriftScenario& s, const AlarmMethod& method, const Samples& signal, Eigen::Index sensor) {
  AlarmTrace t;
  Sprt sprt(s.sprt);
  Cusum cusum(s.cusum);
  const Threshold threshold(s.threshold);
  for (Eigen::Index i = 0; i < signal.rows(); ++i) {
    const double d = signal(i, sensor);
    const int alarm = method.test == AlarmMethod::Test::sprt    ? sprt.update(d)
                      : method.test == AlarmMethod::Test::cusum ? cusum.update(d)
                                                                : threshold.update(d);
    t.alarm.push_back(alarm);
    t.decision.push_back(method.test == AlarmMethod::Test::sprt ? sprt.decision() : alarm);
  }
  return t;
}

std::vector<double> outcome(const DriftScenario& s, const MonitoredRealisation& r) {
  const OutcomeLayout at(s);
  std::vector<double> row(at.size(), kNone);
  const std::size_t p = s.data.sensors.size();
  for (std::size_t m = 0; m < s.methods.size(); ++m)
    for (std::size_t j = 0; j < p; ++j) {
      const std::size_t a = s.methods[m].architecture;
      const AlarmTrace with = alarms(s, s.methods[m], r.with[a].signal, static_cast<Eigen::Index>(j)),
                       without = alarms(s, s.methods[m], r.without[a].signal, static_cast<Eigen::Index>(j));
      row[at.alarm(m, j, OutcomeLayout::first)] = first_hour(s, with, 0);
      row[at.alarm(m, j, OutcomeLayout::first_after_start)] = first_hour(s, with, s.start_h);
      row[at.alarm(m, j, OutcomeLayout::count)] =
          static_cast<double>(with.alarm.size()) -
          static_cast<double>(std::count(with.alarm.begin(), with.alarm.end(), 0));
      row[at.alarm(m, j, OutcomeLayout::first_without_drift)] = first_hour(s, without, 0);
    }
  for (std::size_t a = 0; a < s.architectures.size(); ++a) {
    const auto put = [&](OutcomeLayout::Error what, const Samples& prediction, const Samples& target) {
      const Eigen::RowVectorXd mse = mean_square_error(prediction, target);
      for (std::size_t j = 0; j < p; ++j) row[at.error(a, j, what)] = mse[static_cast<Eigen::Index>(j)];
    };
    put(OutcomeLayout::measured, r.without[a].prediction, r.readings);
    put(OutcomeLayout::drift_measured, r.with[a].prediction, r.readings);
    if (r.truth.size() > 0) {
      put(OutcomeLayout::truth, r.without[a].prediction, r.truth);
      put(OutcomeLayout::drift_truth, r.with[a].prediction, r.truth);
    }
    const Eigen::MatrixXd sensitivity = sensitivities(r.with[a].prediction, r.without[a].prediction, r.drift);
    for (std::size_t j = 0; j < p; ++j)
      for (std::size_t k = 0; k < p; ++k)
        row[at.sensitivity(a, j, k)] = sensitivity(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k));
    row[at.skipped(a)] = static_cast<double>(r.with[a].skipped);
  }
  for (std::size_t j = 0; j < p; ++j) row[at.sd(j)] = r.model.scaling.sd[static_cast<Eigen::Index>(j)];
  return row;
}

Experiment drift_monitoring_experiment() {
  return {"drift_monitoring", "Sensor drift: when monitors find it, and whom they blame, by AAKR-SPRT and AAKR-KF-SPRT",
          "Boechat, Moreno and Haramura, on-line calibration monitoring for oil well sensors",
          [](ConfigReader& config, std::uint64_t seed) -> std::unique_ptr<StudyPoint> {
            return std::make_unique<DriftMonitoring>(read_drift_scenario(config, seed));
          }};
}

}  // namespace surveymc
