/// Study: do on-line calibration monitors find the sensors that drift, how soon, and do they blame healthy ones?
/// AAKR-SPRT and AAKR-KF-SPRT of Boechat, Moreno and Haramura, on a simulated gas-lift well or on a user's file.
///
///   truth -> noise (a realisation) -> scaling, memory (training) -> monitor without and with drift -> alarms, metrics
#include "drift_monitoring/study.h"

#include <fmt/format.h>

#include "base/error.h"
#include "study/experiment.h"

namespace surveymc::studies::drift_monitoring {
namespace {

class DriftMonitoring final : public study::StudyPoint {
 public:
  explicit DriftMonitoring(Scenario scenario) : s_(std::move(scenario)) {}

  stats::Tally run_block(montecarlo::TrialBlock block) const override {
    stats::Tally tally;
    tally.trials = static_cast<std::uint64_t>(block.count);
    for (int i = 0; i < block.count; ++i) {
      const std::vector<double> row = monitor(s_, block.first + static_cast<std::uint64_t>(i), false).outcome;
      tally.samples.insert(tally.samples.end(), row.begin(), row.end());
    }
    return tally;
  }

  study::PointResult report(const stats::Tally& tally, const montecarlo::RunOptions& options) const override {
    const Scenario& s = s_;
    const Monitored shown = monitor(s, 0, s.series_every > 0, options.stop);
    const Outcomes o(s, s.data.simulated() ? tally.samples : shown.outcome);
    const std::string at = study::at_confidence(s.verdict.confidence);
    study::PointResult r;
    std::vector<study::ComparisonRow> metrics = metric_rows(s, o), claims = claim_rows(s, o);
    s.annotations.apply("metrics", metrics);
    s.annotations.apply("claims", claims);
    r.tables = {study::comparison_table("metrics", "accuracy and sensitivity, means over realisations" + at, metrics,
                                        o.trials(), 0, true),
                alarms_table(s, o),
                delay_table(s, o),
                blame_table(s, o),
                study::comparison_table("claims", "what the source says of the two architectures" + at, claims,
                                        o.trials(), 0, true),
                model_table(s, shown.model)};
    if (s.series_every > 0) r.tables.push_back(shown.series);
    if (!s.operating.empty()) r.tables.push_back(operating_table(s, o));
    if (s.methods.size() > s.architectures.size()) r.tables.push_back(baselines_table(s));
    if (!s.searched.empty()) r.tables.push_back(bandwidth_table(s));
    if (s.data.file) r.tables.push_back(data_quality_table(s.data));
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const Scenario& s = s_;
    const OutcomeLayout at(s);
    const std::vector<double> row = monitor(s, trial, false).outcome;
    std::string text = fmt::format("realisation {}: first alarm, h into the test\n", trial);
    for (std::size_t m = 0; m < s.methods.size(); ++m)
      for (std::size_t j = 0; j < s.data.sensors.size(); ++j)
        text += fmt::format("{:<16} {:<12} {:.17g}\n", s.methods[m].name, s.data.sensors[j],
                            row[at.alarm(m, j, OutcomeLayout::first)]);
    return text;
  }

 private:
  Scenario s_;
};

class DriftMonitoringPlan final : public study::PointPlan {
 public:
  explicit DriftMonitoringPlan(Scenario scenario) : s_(std::move(scenario)) {}
  /// Nothing is drawn for a file: its one pass is in report().
  std::uint64_t trials() const override { return s_.data.simulated() ? s_.trials : 0; }
  int block_trials() const override { return 4; }  // a realisation takes tens of milliseconds
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions& options) const override {
    Scenario s = with_data(s_, options);
    calibrate_baselines(s, options);
    return std::make_unique<DriftMonitoring>(std::move(s));
  }

 private:
  Scenario s_;
};

/// Monitors of all architectures on one stream of readings.
std::vector<monitoring::MonitorStream> monitors(const Scenario& s, const monitoring::Aakr& aakr) {
  std::vector<monitoring::MonitorStream> all;
  for (const monitoring::Architecture a : s.architectures) all.emplace_back(a, aakr, s.filter);
  return all;
}

}  // namespace

TrainedModel train_model(const Scenario& s, const monitoring::Samples& training) {
  if (s.model) return *s.model;
  TrainedModel m{monitoring::fit_scaling(training), {}, s.bandwidth};
  const monitoring::Samples z = m.scaling.to_z(training);
  m.memory = monitoring::rows_of(z, monitoring::select_memory(z, s.memory_vectors));
  return m;
}

Monitored monitor(const Scenario& s, std::uint64_t trial, bool with_series, const std::atomic<bool>* stop) {
  const monitoring::Samples simulated = s.data.simulated() ? s.realisation(trial) : monitoring::Samples{};
  Monitored m;
  m.model = train_model(s, s.data.simulated() ? simulated.topRows(s.data.train) : s.data.training);
  const monitoring::Aakr aakr(m.model.memory, m.model.bandwidth);
  std::vector<monitoring::MonitorStream> with = monitors(s, aakr), without = monitors(s, aakr);
  OutcomeSum outcome(s);
  SeriesSum series(s);
  const bool drifts = s.any_drifts();
  for_each_block(s, simulated, [&](const ReadingBlock& in) {
    if (stop && *stop) throw Interrupted("stopped before all rows were monitored");
    MonitoredBlock block;
    block.test_h = in.test_h;
    block.readings = m.model.scaling.to_z(in.readings);
    if (in.truth.size() > 0) block.truth = m.model.scaling.to_z(in.truth);
    block.drift.resize(block.readings.rows(), s.sensors());
    for (Eigen::Index i = 0; i < block.drift.rows(); ++i)
      block.drift.row(i) = s.drift(in.test_h[static_cast<std::size_t>(i)]);
    for (std::size_t a = 0; a < s.architectures.size(); ++a) {
      block.without.push_back(without[a].next(block.readings));
      block.with.push_back(drifts ? with[a].next(block.readings + block.drift) : block.without[a]);
    }
    outcome.add(block);
    if (with_series) series.add(block);
  });
  m.outcome = outcome.row(m.model);
  if (with_series) m.series = series.take();
  return m;
}

study::Experiment experiment() {
  return {random::StudyId::drift_monitoring,
          "Sensor drift: when monitors find it, and whom they blame, by AAKR-SPRT and AAKR-KF-SPRT",
          "Boechat, Moreno and Haramura, on-line calibration monitoring for oil well sensors",
          [](config::ConfigReader& config, random::StudySeed seed) -> std::unique_ptr<study::PointPlan> {
            return std::make_unique<DriftMonitoringPlan>(read_scenario(config, seed));
          }};
}

}  // namespace surveymc::studies::drift_monitoring
