/// Study: do on-line calibration monitors find the sensors that drift, how soon, and do they blame healthy ones?
/// AAKR-SPRT and AAKR-KF-SPRT of Boechat, Moreno and Haramura, on a simulated gas-lift well or on a user's file.
///
///   truth -> noise (a realisation) -> scaling, memory (training) -> monitor without and with drift -> alarms, metrics
#include "drift_monitoring/study.h"

#include <algorithm>

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
    const std::string at = compare::at_confidence(s.verdict.confidence);
    study::PointResult r;
    std::vector<compare::ComparisonRow> metrics = metric_rows(s, o), claims = claim_rows(s, o);
    s.annotations.apply("metrics", metrics);
    s.annotations.apply("claims", claims);
    r.tables = {compare::comparison_table("metrics", "accuracy and sensitivity, means over realisations" + at, metrics,
                                          o.trials(), 0, true),
                alarms_table(s, o),
                delay_table(s, o),
                blame_table(s, o),
                compare::comparison_table("claims", "what the source says of the two architectures" + at, claims,
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

class DriftMonitoringPlan final : public study::PlanOf<Scenario> {
 public:
  using PlanOf::PlanOf;
  int block_trials() const override { return 4; }  // a realisation takes tens of milliseconds
  std::unique_ptr<study::StudyPoint> prepare(const montecarlo::RunOptions& options) const override {
    Scenario s = with_data(s_, options);
    calibrate_baselines(s, options);
    return std::make_unique<DriftMonitoring>(std::move(s));
  }
};

/// Monitors of all architectures on one stream of readings. Predictions that are known are not computed; others are
/// kept if that is wanted.
class Monitors {
 public:
  Monitors(const Scenario& s, const monitoring::Aakr& aakr, bool with_nearest, std::shared_ptr<const Predictions> known,
           bool keeps)
      : known_(std::move(known)), keeps_(keeps && !known_), rows_(keeps_ ? s.data.tested() : 0) {
    for (const monitoring::Architecture a : s.architectures) streams_.emplace_back(a, aakr, s.filter, with_nearest);
    kept_.assign(streams_.size(), monitoring::Samples(rows_, s.sensors()));
  }

  std::vector<monitoring::MonitorTrace> next(const monitoring::Samples& readings) {
    std::vector<monitoring::MonitorTrace> traces;
    for (std::size_t a = 0; a < streams_.size(); ++a)
      traces.push_back(known_ ? streams_[a].next(readings, (*known_)[a].middleRows(row_, readings.rows()))
                              : streams_[a].next(readings));
    add(traces);
    return traces;
  }
  /// As if they had been fed what `others`, at the same row, have just made these traces of.
  void follow(const Monitors& others, const std::vector<monitoring::MonitorTrace>& traces) {
    streams_ = others.streams_;
    add(traces);
  }
  /// Empty unless they were to be kept.
  Predictions take() { return keeps_ ? std::move(kept_) : Predictions{}; }

 private:
  void add(const std::vector<monitoring::MonitorTrace>& traces) {
    const Eigen::Index count = traces.front().prediction.rows();
    for (std::size_t a = 0; keeps_ && a < streams_.size(); ++a) kept_[a].middleRows(row_, count) = traces[a].prediction;
    row_ += count;
  }

  std::vector<monitoring::MonitorStream> streams_;
  std::shared_ptr<const Predictions> known_;
  bool keeps_;
  Eigen::Index rows_, row_ = 0;
  Predictions kept_;
};

/// Rows first .. first + count - 1.
ReadingBlock rows_of(const ReadingBlock& b, Eigen::Index first, Eigen::Index count) {
  ReadingBlock out;
  out.test_h.assign(b.test_h.begin() + first, b.test_h.begin() + first + count);
  out.readings = b.readings.middleRows(first, count);
  if (b.truth.size() > 0) out.truth = b.truth.middleRows(first, count);
  return out;
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
  const bool drifts = s.any_drifts();
  const auto made_by = [&](const std::shared_ptr<SharedPredictions>& shared) {
    const bool are_shared = shared && shared->are_shared() && !with_series;
    return Monitors(s, aakr, with_series, are_shared ? shared->find(trial) : nullptr, are_shared);
  };
  Monitors without = made_by(s.shared_without), with = made_by(s.shared_with);
  OutcomeSum outcome(s);
  SeriesSum series(s);
  bool has_drifted = false;
  const auto add = [&](const ReadingBlock& in) {
    MonitoredBlock block;
    block.test_h = in.test_h;
    block.readings = m.model.scaling.to_z(in.readings);
    if (in.truth.size() > 0) block.truth = m.model.scaling.to_z(in.truth);
    block.drift.resize(block.readings.rows(), s.sensors());
    for (Eigen::Index i = 0; i < block.drift.rows(); ++i)
      block.drift.row(i) = s.drift(in.test_h[static_cast<std::size_t>(i)]);
    has_drifted = has_drifted || (drifts && in.test_h.back() > s.start_h);
    block.without = without.next(block.readings);
    if (has_drifted) {
      block.with = with.next(block.readings + block.drift);
    } else {
      block.with = block.without;
      with.follow(without, block.without);
    }
    outcome.add(block);
    if (with_series) series.add(block);
  };
  for_each_block(s, simulated, [&](const ReadingBlock& in) {
    if (stop && *stop) throw Interrupted("stopped before all rows were monitored");
    // Until the drift begins there is one stream of readings, not two.
    const auto n = static_cast<Eigen::Index>(in.test_h.size());
    const Eigen::Index onset =
        has_drifted ? 0 : std::upper_bound(in.test_h.begin(), in.test_h.end(), s.start_h) - in.test_h.begin();
    if (onset > 0) add(rows_of(in, 0, onset));
    if (onset < n) add(rows_of(in, onset, n - onset));
  });
  m.outcome = outcome.row(m.model);
  if (with_series) m.series = series.take();
  if (Predictions kept = without.take(); !kept.empty()) s.shared_without->keep(trial, std::move(kept));
  if (Predictions kept = with.take(); !kept.empty()) s.shared_with->keep(trial, std::move(kept));
  return m;
}

study::Experiment experiment() {
  return {random::StudyId::drift_monitoring,
          "Sensor drift: when monitors find it, and whom they blame, by AAKR-SPRT and AAKR-KF-SPRT",
          "Boechat, Moreno and Haramura, on-line calibration monitoring for oil well sensors",
          study::plan_of<DriftMonitoringPlan, read_scenario>};
}

}  // namespace surveymc::studies::drift_monitoring
