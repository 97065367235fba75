#pragma once
/// One point of the study `drift_monitoring` (see study.cpp).
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "compare/comparison.h"
#include "compare/table_rows.h"
#include "drift_monitoring/scenario.h"
#include "monitoring/alarm_tests.h"
#include "monitoring/metrics.h"
#include "stats/layout.h"
#include "study/experiment.h"

namespace surveymc::studies::drift_monitoring {

/// Rows that follow each other, in the units of the sensors.
struct ReadingBlock {
  std::vector<double> test_h;           ///< hours from the first monitored sample
  monitoring::Samples readings, truth;  ///< truth is empty where it is not known
};
/// Calls each(block) for the monitored rows in order. `simulated`: realisation() of a simulated well; a file is read.
void for_each_block(const Scenario& s, const monitoring::Samples& simulated,
                    const std::function<void(const ReadingBlock&)>& each);

/// The same, monitored with and without drift. Everything in z.
struct MonitoredBlock {
  std::vector<double> test_h;
  monitoring::Samples truth, readings, drift;           ///< readings without drift
  std::vector<monitoring::MonitorTrace> with, without;  ///< per architecture
};

/// One realisation.
struct Monitored {
  TrainedModel model;
  std::vector<double> outcome;  ///< see OutcomeLayout
  store::Table series;          ///< if it was asked for
};
/// Trains and monitors, block by block: the memory it needs does not depend on the length of a file. Predictions that
/// other points have, too, are taken from them, and kept for them.
/// Throws Interrupted when *stop is set.
Monitored monitor(const Scenario& s, std::uint64_t trial, bool with_series, const std::atomic<bool>* stop = nullptr);

/// Scaling and memory of fault-free readings (n x p, in their units), or the model that the config names.
TrainedModel train_model(const Scenario& s, const monitoring::Samples& training);

/// Sets the thresholds of the baselines by calibration_trials fault-free realisations, which the run does not use. Each
/// baseline then raises an alarm (of any sensor) in as many realisations as the SPRT on the same residual: its
/// threshold is just above the largest value in the others. Throws Interrupted when *options.stop is set. Points of a
/// task share it, unless the model is given.
void calibrate_baselines(Scenario& s, const montecarlo::RunOptions& options);

/// Layout of the numbers of a realisation in its row of Tally::samples.
class OutcomeLayout : public stats::Layout {
  std::size_t p_, methods_, architectures_;

 public:
  explicit OutcomeLayout(const Scenario& s)
      : p_(static_cast<std::size_t>(s.sensors())), methods_(s.method_count()), architectures_(s.architectures.size()) {}

  // h, or NaN: none; the last: samples up to the first alarm if no sensor drifts, or all, if there is none.
  enum Alarm { first, first_after_start, count, first_without_drift, samples_without_drift, kAlarmValues };
  enum Error { measured, truth, drift_measured, drift_truth, kErrors };  // mean squares, z2

  stats::Slots alarm = slots(methods_, p_, kAlarmValues);    ///< of a method and sensor
  stats::Slots error = slots(architectures_, p_, kErrors);   ///< of an architecture and sensor
  stats::Slots sensitivity = slots(architectures_, p_, p_);  ///< of sensor j to a drift of sensor k
  stats::Slots skipped = slots(architectures_), sd = slots(p_);
};

/// Gathers the row of one realisation from its blocks.
class OutcomeSum {
 public:
  explicit OutcomeSum(const Scenario& s);
  void add(const MonitoredBlock& block);
  std::vector<double> row(const TrainedModel& model) const;

 private:
  /// Methods that are one test of one architecture's signal with several settings.
  struct Family {
    std::size_t architecture;
    AlarmMethod::Test test;
    std::vector<std::size_t> methods;
    std::vector<monitoring::AlarmTests> with = {}, without = {};  // [sensor]
    std::vector<double> quiet = {};  // [sensor][method]: samples without drift up to the first alarm
  };
  monitoring::AlarmTests tests_of(const Family& family) const;

  const Scenario& s_;
  OutcomeLayout at_;
  std::vector<double> skipped_;  // [architecture]
  std::vector<Family> families_;
  std::vector<monitoring::MeanSquareError> errors_;       // [architecture][OutcomeLayout::Error]
  std::vector<monitoring::Sensitivities> sensitivities_;  // [architecture]
};

/// Gathers the table `series` from the blocks of a realisation.
class SeriesSum {
 public:
  explicit SeriesSum(const Scenario& s);
  void add(const MonitoredBlock& block);
  store::Table take();

 private:
  const Scenario& s_;
  Eigen::Index row_ = 0;
  std::vector<monitoring::Sprt> tests_;    // [architecture][sensor]
  std::vector<int> held_;                  // the same: decision since the row that was kept before
  std::vector<std::vector<double>> kept_;  // [sensor]: values of its rows
};

/// Rows of all realisations, one after the other, as they stand in a tally.
class Outcomes {
 public:
  Outcomes(const Scenario& s, const std::vector<double>& rows) : at(s), rows_(rows) {}
  std::size_t trials() const { return rows_.size() / at.size(); }
  double operator()(std::size_t trial, std::size_t value) const { return rows_[trial * at.size() + value]; }
  std::vector<double> all(std::size_t value) const {
    std::vector<double> x;
    for (std::size_t t = 0; t < trials(); ++t) x.push_back((*this)(t, value));
    return x;
  }
  OutcomeLayout at;

 private:
  const std::vector<double>& rows_;
};

std::vector<compare::ComparisonRow> metric_rows(const Scenario& s, const Outcomes& o);
/// The paper's qualitative claims: "agrees" where the interval (with one realisation: the value) confirms them.
std::vector<compare::ComparisonRow> claim_rows(const Scenario& s, const Outcomes& o);

/// Hours from the start of a sensor's drift to its first alarm by a method, rising; a miss is infinite.
struct Delays {
  std::vector<double> sorted;
  std::uint64_t missed = 0;
};
Delays delays_of(const Scenario& s, const Outcomes& o, std::size_t method, std::size_t sensor);

/// Realisations in which any healthy sensor raised an alarm by a method.
std::uint64_t count_blames(const Scenario& s, const Outcomes& o, std::size_t method);

/// Columns that several tables have: quantiles of delays; trials and failed.
void write_delays(compare::TableRows& t, const Delays& delays, double confidence);
void write_counts(compare::TableRows& t, const Outcomes& o);

store::Table alarms_table(const Scenario& s, const Outcomes& o);
store::Table delay_table(const Scenario& s, const Outcomes& o);
store::Table blame_table(const Scenario& s, const Outcomes& o);
store::Table model_table(const Scenario& s, const TrainedModel& m);
/// The settings that calibrate_baselines() found, or that were given.
store::Table baselines_table(const Scenario& s);
/// Delay and misses of every drifting sensor against false alarms, for each setting of [operating].
store::Table operating_table(const Scenario& s, const Outcomes& o);
store::Table bandwidth_table(const Scenario& s);
store::Table data_quality_table(const MonitoringData& d);

}  // namespace surveymc::studies::drift_monitoring
