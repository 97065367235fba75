#pragma once
/// The checked settings of a config of `drift_monitoring`.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/annotations.h"
#include "compare/verdict.h"
#include "config/sensor_csv.h"
#include "drift_monitoring/shared_predictions.h"
#include "monitoring/bandwidth.h"
#include "monitoring/gas_lift_well.h"
#include "monitoring/monitor.h"
#include "monitoring/sequential_tests.h"
#include "montecarlo/run_blocks.h"
#include "random/study_id.h"

namespace surveymc::studies::drift_monitoring {

/// A user's file: the columns to read, and the findings on its rows.
struct SensorFile {
  config::InputFile file;
  config::SensorCsvOptions options;
  config::SensorQuality found;
};

/// Readings to train on and to monitor, in the units of the sensors. A file is not held in memory, but read again while
/// it is monitored; only a bounded part to train on is held.
struct MonitoringData {
  std::vector<std::string> sensors, units;
  std::optional<SensorFile> file;  ///< else a simulated well, with:
  monitoring::InjectionSchedule schedule;
  double sample_s = 0, noise_to_signal = 0;
  std::vector<double> time_h;    ///< of every sample; set, as the next members, by set_samples()
  monitoring::Samples readings;  ///< without noise
  Eigen::RowVectorXd noise_sd;   ///< drawn for every realisation

  Eigen::Index rows = 0, train = 0;         ///< samples; the first `train` of them train the model
  double test_start_h = 0, test_end_h = 0;  ///< first monitored sample; last one, hours from the first monitored
  monitoring::Samples training;             ///< of the file; of a simulated well without noise
  Eigen::Index thinned = 1;                 ///< every so many-th row of the file is in `training`

  bool simulated() const { return !file; }
  Eigen::Index tested() const { return rows - train; }
  Eigen::Index training_rows() const { return simulated() ? train : training.rows(); }
};

/// A model that was trained before: the table `model` of a result.
struct TrainedModel {
  monitoring::Scaling scaling;
  monitoring::Samples memory;  ///< z
  double bandwidth = 0;
};

/// How alarms are raised: an architecture with its SPRT, or another test on the residual of AAKR.
struct AlarmMethod {
  std::string name;
  std::size_t architecture;  ///< index in `architectures`: whose signal is tested
  enum class Test { sprt, cusum, threshold } test;
  double setting = 0;  ///< z: shift M of the SPRT, threshold of the others
};

/// `[model.search]`: bandwidths that are tried on the first realisation's training data.
struct BandwidthSearch {
  std::vector<double> tried;
  int folds = 5;
  bool truth = false;  ///< the target is the truth; false: the measured values
};

struct Scenario {
  random::StudySeed seed;
  std::uint64_t trials = 1;
  std::vector<monitoring::Architecture> architectures;
  std::vector<AlarmMethod> methods;
  std::vector<AlarmMethod> operating;  ///< the same tests at other settings, for the operating curves
  MonitoringData data;
  std::optional<TrainedModel> model;  ///< else trained in every realisation
  Eigen::Index memory_vectors = 0;
  double bandwidth = 0;
  std::optional<BandwidthSearch> search;             ///< else `bandwidth` as given
  std::vector<monitoring::BandwidthScore> searched;  ///< results of the search
  Eigen::RowVectorXd amplitude;                      ///< z at the end of the test, signed; 0: healthy
  double start_h = 0;
  monitoring::SprtOptions sprt;
  monitoring::DriftFilterOptions filter;
  monitoring::CusumOptions cusum;
  double threshold = 3;
  std::uint64_t calibration_trials = 0;  ///< 0: thresholds of CUSUM and plain threshold as given
  std::uint64_t calibration_alarms = 0;  ///< of them, those in which the SPRT raised an alarm
  Eigen::Index series_every = 1;         ///< 0: no series
  compare::VerdictRule verdict;
  compare::Annotations annotations;
  /// Of a simulated well whose bandwidth is given, or null: without drift, and with it.
  std::shared_ptr<SharedPredictions> shared_without, shared_with;

  /// `methods`, then `operating`.
  std::size_t method_count() const { return methods.size() + operating.size(); }
  const AlarmMethod& method(std::size_t m) const {
    return m < methods.size() ? methods[m] : operating[m - methods.size()];
  }
  Eigen::Index sensors() const { return static_cast<Eigen::Index>(data.sensors.size()); }
  bool drifts(Eigen::Index sensor) const { return amplitude[sensor] != 0; }
  /// z, of all sensors, so many hours into the test: linear from start_h to the last sample.
  Eigen::RowVectorXd drift(double test_h) const;
  bool any_drifts() const { return amplitude.cwiseAbs().maxCoeff() > 0; }
  bool any_healthy() const { return (amplitude.array() == 0).any(); }
  /// Readings of one realisation of a simulated well, all samples, in the units of the sensors.
  monitoring::Samples realisation(std::uint64_t trial) const;
};

/// `[source]`. Throws InputError.
MonitoringData read_monitoring_data(config::ConfigReader& config, bool has_model);

/// Throws InputError. A simulated well is not simulated yet, nor a bandwidth searched, nor a baseline calibrated.
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

/// The scenario with the well simulated and the bandwidth chosen; calibrate_baselines() is not called yet. Throws
/// InputError where a sensor of the well does not vary. Points of a task share the simulation and the search.
Scenario with_data(Scenario scenario, const montecarlo::RunOptions& options);

/// Samples that are equal bit by bit, wherever they are.
struct ExactSamples {
  std::shared_ptr<const monitoring::Samples> values;
  const monitoring::Samples& operator*() const { return *values; }
  std::size_t bytes() const { return sizeof(double) * static_cast<std::size_t>(values->size()); }
  friend bool operator==(const ExactSamples& a, const ExactSamples& b);
};

/// The samples of a simulated well, without noise.
ExactSamples simulated_samples(const MonitoringData& data, const montecarlo::RunOptions& options);
/// Gives a simulated well its samples, and what follows from them.
void set_samples(MonitoringData& data, const monitoring::Samples& samples);

/// Names of the rows of the tables `metrics` and `claims`.
std::vector<compare::Row> row_names(const Scenario& s);

}  // namespace surveymc::studies::drift_monitoring
