#pragma once
/// One point of the study `drift_monitoring` (see drift_monitoring.cpp).
#include <string>
#include <vector>

#include "drift_monitoring_scenario.h"
#include "study/comparison.h"
#include "study/experiment.h"

namespace surveymc {

/// One realisation, monitored with and without drift. Everything in z.
struct MonitoredRealisation {
  TrainedModel model;
  Samples truth, readings, drift;           ///< truth is empty where it is not known; readings without drift
  std::vector<MonitorTrace> with, without;  ///< per architecture
};
MonitoredRealisation monitor(const DriftScenario& s, std::uint64_t trial);

/// Alarms of one method on one sensor: +1 or -1 at samples that raise one; `decision` holds in between.
struct AlarmTrace {
  std::vector<int> alarm, decision;
};
AlarmTrace alarms(const DriftScenario& s, const AlarmMethod& method, const Samples& signal, Eigen::Index sensor);

/// Where the numbers of a realisation stand in its row of Tally::samples.
class OutcomeLayout {
 public:
  explicit OutcomeLayout(const DriftScenario& s)
      : p_(static_cast<std::size_t>(s.sensors())), methods_(s.methods.size()), architectures_(s.architectures.size()) {}

  enum Alarm { first, first_after_start, count, first_without_drift, kAlarmValues };  // h, or NaN: none
  enum Error { measured, truth, drift_measured, drift_truth, kErrors };               // mean squares, z2

  std::size_t alarm(std::size_t method, std::size_t sensor, Alarm what) const {
    return (method * p_ + sensor) * kAlarmValues + what;
  }
  std::size_t error(std::size_t architecture, std::size_t sensor, Error what) const {
    return methods_ * p_ * kAlarmValues + (architecture * kErrors + what) * p_ + sensor;
  }
  /// Of sensor j to a drift of sensor k.
  std::size_t sensitivity(std::size_t architecture, std::size_t j, std::size_t k) const {
    return error(architectures_, 0, measured) + (architecture * p_ + j) * p_ + k;
  }
  std::size_t skipped(std::size_t architecture) const { return sensitivity(architectures_, 0, 0) + architecture; }
  std::size_t sd(std::size_t sensor) const { return skipped(architectures_) + sensor; }
  std::size_t size() const { return sd(p_); }

 private:
  std::size_t p_, methods_, architectures_;
};

/// The row of one realisation.
std::vector<double> outcome(const DriftScenario& s, const MonitoredRealisation& r);

/// Rows of all realisations, one after the other, as they stand in a tally.
class Outcomes {
 public:
  Outcomes(const DriftScenario& s, const std::vector<double>& rows) : at(s), rows_(rows) {}
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

std::vector<ComparisonRow> metric_rows(const DriftScenario& s, const Outcomes& o);
/// The paper's qualitative claims: "agrees" where the interval (of one realisation, the value) holds them.
std::vector<ComparisonRow> claim_rows(const DriftScenario& s, const Outcomes& o);

Table alarms_table(const DriftScenario& s, const Outcomes& o);
Table delay_table(const DriftScenario& s, const Outcomes& o);
Table blame_table(const DriftScenario& s, const Outcomes& o);
Table model_table(const DriftScenario& s, const MonitoredRealisation& r);
Table series_table(const DriftScenario& s, const MonitoredRealisation& r);
Table bandwidth_table(const DriftScenario& s);
Table data_quality_table(const SensorCsv& found);

}  // namespace surveymc
