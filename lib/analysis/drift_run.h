#pragma once
/// One well with an MWD tool whose sensors drift, and two monitors beside it: a sequential probability ratio test
/// (SPRT) on each channel, and a Kalman filter on the six biases (monitoring/survey_drift.h).
///   readings with noise and biases -> channels |g|, |b|, dip, less a reference that scatters -> both monitors
/// SI: m/s2, nT, rad.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "analysis/drift_lanes.h"
#include "monitoring/sequential_tests.h"
#include "monitoring/survey_drift.h"
#include "random/study_id.h"
#include "survey/reference_field.h"

namespace surveymc::analysis {

struct DriftRunSetup {
  random::StudySeed seed;
  survey::ReferenceField field;
  int stations = 80, from_station = 20;                          ///< from_station: where the drift begins
  double inclination_from = 0, inclination_to = 0, azimuth = 0;  ///< azimuth: magnetic
  monitoring::Vector6 noise, drift_at_td, walk;  ///< one sd; at the last station; sd of a station's step
  Eigen::Vector3d scatter;                       ///< of the reference: gravity, total field, dip
  monitoring::SprtOptions sprt;                  ///< in sd of a channel
  double alarm_sd = 3;                           ///< of the filter: bias over its sd

  double inclination(int k) const {
    return inclination_from + (inclination_to - inclination_from) * k / (stations - 1);
  }
  /// Share of the drift that a station has.
  double ramp(int k) const {
    return std::max(0.0, static_cast<double>(k - from_station) / (stations - 1 - from_station));
  }
};

/// How the biases of the sensors change.
enum class SensorBias {
  none,
  ramp,  ///< one sensor drifts linearly
  walk,  ///< all six walk exactly as the filter assumes, to test the filter's consistency
};

/// Truth and results at one station.
struct DriftingStation {
  Eigen::Vector3d channels;             ///< less reference, in their sd without drift
  std::array<int, 3> sprt{};            ///< decision that holds, by channel
  monitoring::Vector6 truth, bias, sd;  ///< of the sensors' biases: true, estimated, sd of the estimate
  int named = -1;                       ///< sensor with the largest bias over sd, if that is an alarm
};

/// One well.
struct DriftRun {
  int sprt_alarm = -1, filter_alarm = -1, named = -1;  ///< stations of first alarms; sensor named at the filter's
  double nis_mean = 0, nis_inside = 0, nees_mean = 0;  ///< over the stations; share of NIS below its 95 % quantile
  std::vector<DriftingStation> stations;               ///< if asked for
};
/// Trial `trial` of the setup. The same draws for every `bias`, so that runs with and without drift differ by the
/// drift.
DriftRun drift_run(const DriftRunSetup& s, std::uint64_t trial, SensorBias bias, bool keep_stations = false);

/// The results of a trial with all three kinds of biases.
using DriftValues = std::array<double, DriftResult::kValues>;
DriftValues drift_values(const DriftRunSetup& s, std::uint64_t trial);
/// The same for `count` trials from `first` on, side by side: equal to rounding, and independent of `first`.
/// drift_values() computes the trials that the kernel cannot.
std::vector<DriftValues> drift_values(const DriftRunSetup& s, std::uint64_t first, int count);
/// What the kernel gets of eight trials: its columns are in `columns`.
DriftBatch drift_batch(const DriftRunSetup& s, std::uint64_t first, std::vector<double>& columns);

}  // namespace surveymc::analysis
