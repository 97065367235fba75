/// Study: drift of an MWD tool's own sensors along a survey. A Kalman filter on six biases with the Jacobian of the
/// channels |g|, |b| and dip, against a plain SPRT on each channel.
///
///   made-up well, toolfaces (a trial) -> readings with noise and a ramp on one sensor -> channels less reference
///   -> SPRT by channel, and bias filter with its own alarm -> who finds it, when, and whom it names
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "base/units.h"
#include "experiments.h"
#include "monitoring/alarm_tests.h"
#include "monitoring/survey_drift.h"
#include "random/stream.h"
#include "study/scenario.h"
#include "study/table_writer.h"

namespace surveymc {
namespace {

using Eigen::Vector3d;
constexpr double kMilliG = 9.80665e-3;  // m/s2
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<const char*, 6> kSensors{"gx", "gy", "gz", "bx", "by", "bz"};

/// SI: m/s2, nT, rad.
struct MwdScenario {
  std::uint64_t seed = 0, trials = 0;
  ReferenceField field;
  int stations = 80, from_station = 20;
  double spacing = 30, inclination_from = 0, inclination_to = 0, azimuth = 0;
  Vector6 noise, drift_at_td, walk;  ///< one sd; at the last station; sd of a station's step
  Vector3d scatter;                  ///< of the reference: gravity, total field, dip
  SprtOptions sprt;                  ///< in sd of a channel
  double alarm_sd = 3;               ///< of the filter: bias over its sd
  VerdictRule verdict;
  int sensor = -1;  ///< that drifts

  double inclination(int k) const {
    return inclination_from + (inclination_to - inclination_from) * k / (stations - 1);
  }
  /// Share of the drift that has come at a station.
  double ramp(int k) const {
    return std::max(0.0, static_cast<double>(k - from_station) / (stations - 1 - from_station));
  }
};

Vector6 sensor_values(ConfigReader& c, const std::string& key, const Range& range, double accelerometer_mg,
                      double magnetometer_nT) {
  const double a = c.number(key + ".accelerometer_mg", range, accelerometer_mg) * kMilliG;
  const double m = c.number(key + ".magnetometer_nT", range, magnetometer_nT);
  return (Vector6() << a, a, a, m, m, m).finished();
}

MwdScenario read_scenario(ConfigReader& c, std::uint64_t seed) {
  MwdScenario s;
  s.seed = seed;
  s.trials = static_cast<std::uint64_t>(c.integer("trials", 1, 100'000'000));
  s.field = read_field(c);
  s.stations = static_cast<int>(c.integer("well.stations", 3, 100'000, 80));
  s.spacing = c.number("well.spacing_m", Range::positive(), 30);
  s.inclination_from = kDegree * c.number("well.inclination_from_deg", Range::closed(0, 180), 0);
  s.inclination_to = kDegree * c.number("well.inclination_to_deg", Range::closed(0, 180), 60);
  s.azimuth = kDegree * c.number("well.magnetic_azimuth_deg", Range::closed(0, 360), 60);
  s.noise = sensor_values(c, "noise", Range::positive(), 0.2, 20);
  s.walk = sensor_values(c, "walk", Range::positive(), 0.02, 2);
  s.scatter = {kMilliG * c.number("scatter.gravity_mg", Range::non_negative(), 0.1),
               c.number("scatter.total_nT", Range::non_negative(), 30),
               kDegree * c.number("scatter.dip_deg", Range::non_negative(), 0.05)};
  const std::string sensor = c.choice("drift.sensor", {kSensors.begin(), kSensors.end()});
  s.sensor = static_cast<int>(std::find(kSensors.begin(), kSensors.end(), sensor) - kSensors.begin());
  s.drift_at_td = Vector6::Zero();
  s.drift_at_td[s.sensor] =
      s.sensor < 3 ? kMilliG * c.number("drift.at_td_mg", Range{}) : c.number("drift.at_td_nT", Range{});
  s.from_station = static_cast<int>(c.integer("drift.from_station", 0, s.stations - 2, 20));
  s.sprt.shift = c.number("sprt.shift_sd", Range::positive(), 3);
  s.sprt.variance = 1;
  s.sprt.false_alarm = c.number("sprt.false_alarm", Range::open(0, 0.5), 1e-4);
  s.sprt.missed_alarm = c.number("sprt.missed_alarm", Range::open(0, 0.5), 0.10);
  s.alarm_sd = c.number("filter.alarm_sd", Range::positive(), 3);
  s.verdict.confidence = c.number("verdict.confidence", Range::open(0, 1), 0.95);
  c.finish();
  return s;
}

/// One well: alarms, and what the figures show.
struct MwdRun {
  int sprt_alarm = -1, filter_alarm = -1, named = -1;  ///< stations of first alarms; sensor named at the filter's
  std::vector<Vector3d> channels;                      ///< in sd
  std::vector<Vector6> bias, sd;
};

MwdRun run_well(const MwdScenario& s, std::uint64_t trial, bool with_drift) {
  const Stream stream(s.seed, 4);
  MwdRun run;
  BiasFilter filter(s.walk.cwiseAbs2());
  std::array<Sprt, 3> sprt{Sprt(s.sprt), Sprt(s.sprt), Sprt(s.sprt)};
  for (int k = 0; k < s.stations; ++k) {
    const auto station = static_cast<std::uint32_t>(k);
    const double toolface =
        2 * kPi * stream.uniforms<double>(trial, Channel::survey_toolface, station / 4)[station % 4];
    const Attitude at{s.inclination(k), s.azimuth, toolface};
    Vector6 readings;
    const Vec3<double> u = down_T(at), m = magnetic_T(at, s.field.total, s.field.dip);
    const double gravity = s.field.gravity;
    readings << gravity * u.x, gravity * u.y, gravity * u.z, m.x, m.y, m.z;
    for (int j = 0; j < 6; ++j)
      readings[j] +=
          s.noise[j] * stream.normal(trial, Channel::survey_sensor_noise, 6 * station + static_cast<std::uint32_t>(j));
    if (with_drift) readings += s.ramp(k) * s.drift_at_td;
    Vector3d reference(s.field.gravity, s.field.total, s.field.dip);
    for (int i = 0; i < 3; ++i)
      reference[i] +=
          s.scatter[i] * stream.normal(trial, Channel::survey_reference, 4 * station + static_cast<std::uint32_t>(i));

    const Vector3d g(readings[0], readings[1], readings[2]), b(readings[3], readings[4], readings[5]);
    const ChannelJacobian h = survey_channel_jacobian(g, b);
    const Eigen::Matrix3d r = h * Matrix6(s.noise.cwiseAbs2().asDiagonal()) * h.transpose() +
                              Eigen::Matrix3d(s.scatter.cwiseAbs2().asDiagonal());
    const Vector3d y = survey_channels(g, b) - reference;
    filter.update(y, h, r);
    const Vector3d scaled = y.cwiseQuotient(r.diagonal().cwiseSqrt());
    for (int i = 0; i < 3; ++i)
      if (sprt[static_cast<std::size_t>(i)].update(scaled[i]) != 0 && run.sprt_alarm < 0 &&
          k >= (with_drift ? s.from_station : 0))
        run.sprt_alarm = k;
    const Vector6 sd = filter.covariance().diagonal().cwiseSqrt();
    Eigen::Index largest = 0;
    const double ratio = filter.bias().cwiseQuotient(sd).cwiseAbs().maxCoeff(&largest);
    if (ratio >= s.alarm_sd && run.filter_alarm < 0 && k >= (with_drift ? s.from_station : 0)) {
      run.filter_alarm = k;
      run.named = static_cast<int>(largest);
    }
    run.channels.push_back(scaled);
    run.bias.push_back(filter.bias());
    run.sd.push_back(sd);
  }
  return run;
}

class MwdDrift final : public StudyPoint {
 public:
  explicit MwdDrift(MwdScenario s) : s_(std::move(s)) {}
  std::uint64_t trials() const override { return s_.trials; }
  int block_trials() const override { return 64; }

  Tally run_block(TrialBlock block) const override {
    Tally tally;
    tally.trials = static_cast<std::uint64_t>(block.count);
    for (int i = 0; i < block.count; ++i) {
      const std::uint64_t trial = block.first + static_cast<std::uint64_t>(i);
      const MwdRun with = run_well(s_, trial, true), without = run_well(s_, trial, false);
      for (const int x : {with.sprt_alarm, with.filter_alarm, with.named, without.sprt_alarm, without.filter_alarm})
        tally.samples.push_back(x);
    }
    return tally;
  }

  PointResult finish(const Tally& tally) const override {
    PointResult r;
    r.tables = {detection_table(tally), series_table()};
    return r;
  }

  std::string replay(std::uint64_t trial) const override {
    const MwdRun run = run_well(s_, trial, true);
    return fmt::format("well {}: first alarm at station {} (SPRT), {} (filter, which names {}); -1: none\n", trial,
                       run.sprt_alarm, run.filter_alarm,
                       run.named < 0 ? "none" : kSensors[static_cast<std::size_t>(run.named)]);
  }

 private:
  Table detection_table(const Tally& tally) const {
    Table t{"detection", "drift of one sensor along a survey" + at_confidence(s_.verdict.confidence)};
    t.columns = {word_column("method", "channel_sprt or bias_filter"), word_column("sensor", "that drifts")};
    add_with_interval(t, "p_detected", "1", "share of wells with an alarm once the drift has begun");
    for (const char* q : {"delay_q05_stations", "delay_q50_stations", "delay_q95_stations"})
      t.columns.push_back(
          number_column(q, "1", "stations from the start of the drift to the alarm; a miss is infinite"));
    add_with_interval(t, "p_named", "1", "share of these alarms that name the right sensor");
    add_with_interval(t, "p_alarm_without_drift", "1", "share of wells with any alarm if no sensor drifts");
    t.columns.push_back(count_column("trials", "wells"));
    t.columns.push_back(count_column("failed", "wells without a result"));
    TableWriter w(std::move(t));
    for (const bool filter : {false, true}) {
      std::vector<double> delays;
      std::uint64_t detected = 0, named = 0, quiet = 0;
      for (std::uint64_t i = 0; i < tally.trials; ++i) {
        const double* row = tally.samples.data() + 5 * i;
        const double alarm = row[filter ? 1 : 0];
        detected += alarm >= 0;
        named += static_cast<int>(row[2]) == s_.sensor;
        quiet += row[filter ? 4 : 3] >= 0;
        delays.push_back(alarm >= 0 ? alarm - s_.from_station : std::numeric_limits<double>::infinity());
      }
      std::sort(delays.begin(), delays.end());
      w << std::string(filter ? "bias_filter" : "channel_sprt")
        << std::string(kSensors[static_cast<std::size_t>(s_.sensor)]);
      write_share(w, detected, tally.trials);
      for (const double q : {0.05, 0.50, 0.95})
        w << delays[static_cast<std::size_t>(std::ceil(q * static_cast<double>(delays.size()))) - 1];
      write_share(w, named, filter ? detected : 0);
      write_share(w, quiet, tally.trials);
      w << static_cast<std::int64_t>(tally.trials) << std::int64_t{0};
    }
    return w.take();
  }

  void write_share(TableWriter& w, std::uint64_t count, std::uint64_t trials) const {
    const Interval ci = trials > 0 ? binomial_interval(count, trials, s_.verdict.confidence) : Interval{kNone, kNone};
    w << (trials > 0 ? static_cast<double>(count) / static_cast<double>(trials) : kNone) << ci.lo << ci.hi;
  }

  Table series_table() const {
    Table t{"series", "first well, with drift: channels in their sd, and the biases that the filter estimates"};
    t.columns = {number_column("md_m", "m", "measured depth from the first station")};
    for (const char* n : {"gravity_sd", "total_field_sd", "dip_sd"})
      t.columns.push_back(number_column(n, "1", "channel less reference, over its sd without drift"));
    for (std::size_t j = 0; j < 6; ++j) {
      const std::string unit = j < 3 ? "mg" : "nT", of = kSensors[j] + ("_" + unit);
      t.columns.push_back(number_column("bias_" + of, unit, "estimate"));
      t.columns.push_back(number_column("sd_" + of, unit, "of the estimate, one sigma"));
      t.columns.push_back(number_column("true_" + of, unit, "drift of the sensor"));
    }
    const MwdRun run = run_well(s_, 0, true);
    TableWriter w(std::move(t));
    for (int k = 0; k < s_.stations; ++k) {
      const auto i = static_cast<std::size_t>(k);
      w << k * s_.spacing;
      for (int c = 0; c < 3; ++c) w << run.channels[i][c];
      for (int j = 0; j < 6; ++j) {
        const double unit = j < 3 ? kMilliG : 1;
        w << run.bias[i][j] / unit << run.sd[i][j] / unit << s_.ramp(k) * s_.drift_at_td[j] / unit;
      }
    }
    return w.take();
  }

  MwdScenario s_;
};

}  // namespace

Experiment mwd_drift_experiment() {
  return {"mwd_drift", "Drift of a survey tool's own sensors: a Kalman filter on six biases against an SPRT by channel",
          "the idea of AAKR-KF-SPRT, with the reference field as the prediction",
          [](ConfigReader& config, std::uint64_t seed) -> std::unique_ptr<StudyPoint> {
            return std::make_unique<MwdDrift>(read_scenario(config, seed));
          }};
}

}  // namespace surveymc
