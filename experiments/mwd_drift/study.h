#pragma once
/// Parts of the study `mwd_drift` (see study.cpp). SI: m/s2, nT, rad.
#include <array>
#include <string>
#include <vector>

#include "monitoring/sequential_tests.h"
#include "monitoring/survey_drift.h"
#include "random/study_id.h"
#include "study/annotations.h"
#include "study/comparison.h"
#include "study/scenario.h"

namespace surveymc::studies::mwd_drift {

inline constexpr std::array<const char*, 6> kSensors{"gx", "gy", "gz", "bx", "by", "bz"};

struct Scenario {
  random::StudySeed seed;
  std::uint64_t trials = 0;
  survey::ReferenceField field;
  int stations = 80, from_station = 20;
  double spacing = 30, inclination_from = 0, inclination_to = 0, azimuth = 0;
  monitoring::Vector6 noise, drift_at_td, walk;  ///< one sd; at the last station; sd of a station's step
  Eigen::Vector3d scatter;                       ///< of the reference: gravity, total field, dip
  monitoring::SprtOptions sprt;                  ///< in sd of a channel
  double alarm_sd = 3;                           ///< of the filter: bias over its sd
  study::VerdictRule verdict;
  study::Annotations annotations;
  int sensor = -1;  ///< that drifts

  double inclination(int k) const {
    return inclination_from + (inclination_to - inclination_from) * k / (stations - 1);
  }
  /// Share of the drift that has come at a station.
  double ramp(int k) const {
    return std::max(0.0, static_cast<double>(k - from_station) / (stations - 1 - from_station));
  }
};

/// Throws InputError.
Scenario read_scenario(config::ConfigReader& config, random::StudySeed seed);

/// What the sensors do.
enum class SensorBias {
  none,
  ramp,  ///< one sensor drifts linearly
  walk,  ///< all six do just what the filter assumes: its consistency is tested against this
};

/// What is seen at one station.
struct DriftingStation {
  Eigen::Vector3d channels;             ///< less reference, in their sd without drift
  std::array<int, 3> sprt{};            ///< decision that holds, by channel
  monitoring::Vector6 truth, bias, sd;  ///< of the sensors' biases: true, estimated, sd of the estimate
  int named = -1;                       ///< sensor with the largest bias over sd, if that is an alarm
};

/// One well.
struct Run {
  int sprt_alarm = -1, filter_alarm = -1, named = -1;  ///< stations of first alarms; sensor named at the filter's
  double nis_mean = 0, nis_inside = 0, nees_mean = 0;  ///< over the stations; share of NIS below its 95 % quantile
  std::vector<DriftingStation> stations;               ///< if asked for
};
Run run_well(const Scenario& s, std::uint64_t trial, SensorBias bias, bool keep_stations = false);

/// What is kept of a trial: wells with the ramp, without, and with biases that walk.
struct Outcome {
  enum Value { sprt, filter, named, sprt_without, filter_without, nis_mean, nis_inside, nees_mean, kValues };
};

/// The rows of all trials as they stand in a tally.
class Outcomes {
 public:
  explicit Outcomes(const std::vector<double>& rows) : rows_(rows) {}
  std::size_t trials() const { return rows_.size() / Outcome::kValues; }
  double operator()(std::size_t trial, Outcome::Value v) const { return rows_[trial * Outcome::kValues + v]; }

 private:
  const std::vector<double>& rows_;
};

std::vector<study::ComparisonRow> comparison_rows(const Scenario& s, const Outcomes& o);
std::vector<study::ComparisonRow> claim_rows(const Scenario& s, const Outcomes& o);
store::Table detection_table(const Scenario& s, const Outcomes& o);
/// Share of wells with an alarm up to each station.
store::Table alarm_curve_table(const Scenario& s, const Outcomes& o);
store::Table series_table(const Scenario& s);

}  // namespace surveymc::studies::mwd_drift
