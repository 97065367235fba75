#pragma once
/// Truth -> readings: the readings of magnetometers and accelerometers in a true field, trial by trial.
#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "random/reference_laws.h"
#include "random/stream.h"
#include "survey/readings.h"
#include "survey/reference_field.h"
#include "survey/survey.h"

namespace surveymc::sensor {

/// Constant errors of a magnetometer triad: reading m = gain b + bias + noise, per axis of the tool frame
/// (thesis eq 14 with the divisor gain = 1 + e_S of its eq 16).
struct MagnetometerErrors {
  std::array<double, 3> gain{1, 1, 1};
  std::array<double, 3> bias{0, 0, 0};  ///< nT
};

/// Distribution of one magnetometer noise draw; `size` is the number given in the noise model. Accelerometer noise and
/// reference errors are always Gaussian.
enum class NoiseLaw {
  gaussian,            ///< N(0, size^2)
  gaussian_half_open,  ///< |N(0, size^2)|
  uniform,             ///< uniform on (-size, size)
  uniform_half_open,   ///< uniform on (0, size): "a value between 0 and 70 nT"
};
/// When the reference field that estimators are given is drawn anew.
enum class ReferenceNoise { none, per_run, per_station };

struct NoiseModel {
  NoiseLaw law = NoiseLaw::gaussian;
  double magnetometer = 0;   ///< nT, size of the law, per axis and station
  double accelerometer = 0;  ///< m/s2, one standard deviation, per axis and station
  ReferenceNoise reference = ReferenceNoise::none;
  double reference_total = 0;  ///< nT, one standard deviation
  double reference_dip = 0;    ///< rad, one standard deviation
  /// Trials 2j and 2j + 1 are a pair: all draws of the second are exactly the negated draws of the first. Needs a law
  /// that is symmetric about zero; each trial by itself then has the same distribution as without pairs.
  bool antithetic = false;
};

/// V of errors of the reference that are not normal (random/mixing_law.h).
struct ReferenceMixing {
  std::vector<random::MixingSlot> slots;
  std::vector<std::int32_t> slot_of;  ///< [2 pair + {0 total field, 1 dip}]; -1: normal. A pair a station, or one.
};
/// Empty without a law.
ReferenceMixing reference_mixing(const random::ReferenceLaws& laws, const NoiseModel& noise, int stations);

/// Mean and variance of a draw of size 1.
double unit_noise_mean(NoiseLaw law);
double unit_noise_variance(NoiseLaw law);
/// A draw and its negative are equally likely.
bool symmetric(NoiseLaw law);

/// Noise-free readings of a survey by a tool with constant magnetometer errors and perfect accelerometers.
struct CleanReadings {
  std::vector<survey::Vec3<double>> field_T;     ///< true field in the tool frame, nT
  std::vector<survey::Vec3<double>> magnetic_T;  ///< magnetometer readings, nT
  std::vector<survey::Vec3<double>> gravity_T;   ///< accelerometer readings, m/s2, pointing down
  std::vector<survey::Vec3<double>> down_T;      ///< direction of gravity_T, unit vectors
};
CleanReadings clean_readings(const survey::Survey& survey, const survey::ReferenceField& field,
                             const MagnetometerErrors& errors);

/// Readings of an error-free tool at the stations.
std::vector<survey::StationFields> station_fields(const CleanReadings& clean);

/// Linear functions of a trial's draws: kSums sums of weight times draw at a time. Draws are those of size 1, so the
/// weight carries the noise's size. With the weights of a first-order prediction the sums are the prediction for this
/// very trial: its control variate.
struct NoiseWeights {
  static constexpr int kSums = 9;     ///< six parameters and three coordinates
  std::vector<double> magnetometer;   ///< [3 station + axis][kSums]
  std::vector<double> accelerometer;  ///< the same; empty without accelerometer noise
  std::vector<double> reference;      ///< [2 pair + {0 total field, 1 dip}][kSums]; empty without reference noise
  std::vector<double> tool;           ///< [gain x, y, z, bias x, y, z][kSums]; empty unless tools are drawn
};
/// Mean and covariance of the sums, exact.
struct NoiseSumMoments {
  Eigen::Matrix<double, NoiseWeights::kSums, 1> mean;
  Eigen::Matrix<double, NoiseWeights::kSums, NoiseWeights::kSums> covariance;
};
/// `correlation`: of the reference's draws, in the order of `weights.reference`; null: they are independent.
NoiseSumMoments noise_sum_moments(const NoiseWeights& weights, NoiseLaw law,
                                  const Eigen::MatrixXd* correlation = nullptr);

/// A batch of the right shape for this survey and noise.
survey::ReadingBlock make_reading_block(int trials, int stations, const NoiseModel& noise);

/// Fills `out` with noisy readings of trials first_trial, first_trial + 1, ... first_trial is a multiple of kGroup.
/// noise.antithetic needs symmetric(noise.law).
/// `mixing`: of reference_mixing(); null, or empty: all errors of the reference are normal.
/// `made`: the reference's draws in place of the stream's, rows 2 station + {0 total field, 1 dip}.
/// If `weights` is given, `sums` (NoiseWeights::kSums rows) gets the weighted sums of every trial's draws.
void simulate_readings(const CleanReadings& clean, const survey::ReferenceField& field, const NoiseModel& noise,
                       const random::Stream& stream, std::uint64_t first_trial, survey::ReadingBlock& out,
                       const NoiseWeights* weights = nullptr, survey::LaneArray* sums = nullptr,
                       const ReferenceMixing* mixing = nullptr, const survey::LaneArray* made = nullptr);

}  // namespace surveymc::sensor
