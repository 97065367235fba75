#pragma once
/// What a config of `drift_monitoring` says, checked.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config/sensor_csv.h"
#include "monitoring/alarm_tests.h"
#include "monitoring/bandwidth.h"
#include "monitoring/monitor.h"
#include "study/annotations.h"
#include "study/verdict.h"

namespace surveymc {

/// Readings to train on and to monitor, in the units of the sensors.
struct MonitoringData {
  std::vector<std::string> sensors, units;
  std::vector<double> time_h;  ///< of every sample
  Samples readings;            ///< without noise, if simulated
  bool simulated = false;
  Eigen::RowVectorXd noise_sd;     ///< drawn for every realisation; 0 where readings are what they are
  Eigen::Index train = 0;          ///< the first so many samples train the model
  std::optional<SensorCsv> found;  ///< what was wrong with a user's file

  Eigen::Index tested() const { return readings.rows() - train; }
  /// Hours from the first monitored sample.
  double test_h(Eigen::Index i) const {
    return time_h[static_cast<std::size_t>(train + i)] - time_h[static_cast<std::size_t>(train)];
  }
};

/// A model that was trained before: the table `model` of a result.
struct TrainedModel {
  Scaling scaling;
  Samples memory;  ///< z
  double bandwidth = 0;
};

/// How alarms are raised: an architecture with its SPRT, or another test on the residual of AAKR.
struct AlarmMethod {
  std::string name;
  std::size_t architecture;  ///< index in `architectures`: whose signal is tested
  enum class Test { sprt, cusum, threshold } test;
};

struct DriftScenario {
  std::uint64_t seed = 0, trials = 1;
  std::vector<Architecture> architectures;
  std::vector<AlarmMethod> methods;
  MonitoringData data;
  std::optional<TrainedModel> model;  ///< else trained in every realisation
  Eigen::Index memory_vectors = 0;
  double bandwidth = 0;
  std::vector<BandwidthScore> searched;  ///< if the bandwidth was
  Eigen::RowVectorXd amplitude;          ///< z at the end of the test, signed; 0: healthy
  double start_h = 0;
  SprtOptions sprt;
  DriftFilterOptions filter;
  CusumOptions cusum;
  double threshold = 3;
  std::int64_t series_every = 1;  ///< 0: no series
  VerdictRule verdict;
  Annotations annotations;

  Eigen::Index sensors() const { return static_cast<Eigen::Index>(data.sensors.size()); }
  bool drifts(Eigen::Index sensor) const { return amplitude[sensor] != 0; }
  /// n x p, z: linear from start_h to the last sample.
  Samples drift() const;
  /// Readings of one realisation, all samples, in the units of the sensors.
  Samples realisation(std::uint64_t trial) const;
};

/// `[source]`. Throws InputError.
MonitoringData read_monitoring_data(ConfigReader& config, bool has_model);

/// Throws InputError.
DriftScenario read_drift_scenario(ConfigReader& config, std::uint64_t seed);

/// Names of the rows of the tables `metrics` and `claims`.
std::vector<RowName> drift_row_names(const DriftScenario& s);

}  // namespace surveymc
