/// What a config of `mwd_drift` says, checked, and one well of it.
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "mwd_drift/study.h"
#include "random/study_stream.h"
#include "stats/intervals.h"

namespace surveymc::studies::mwd_drift {
namespace {

using Eigen::Vector3d;

monitoring::Vector6 sensor_values(config::ConfigReader& c, const std::string& key, const config::Range& range,
                                  double accelerometer_mg, double magnetometer_nT) {
  const double a = c.number(key + ".accelerometer_mg", range, accelerometer_mg) * kMilliG;
  const double m = c.number(key + ".magnetometer_nT", range, magnetometer_nT);
  return (monitoring::Vector6() << a, a, a, m, m, m).finished();
}

/// Steps of biases that walk: indices of their own, behind those of the noise of 10^8 stations.
constexpr std::uint32_t kFirstStep = std::uint32_t{1} << 30;

double sensor_draw(const random::Stream& stream, std::uint64_t trial, std::uint32_t first, int station, int sensor) {
  return stream.normal(trial, random::Channel::survey_sensor_noise,
                       first + 6 * static_cast<std::uint32_t>(station) + static_cast<std::uint32_t>(sensor));
}

}  // namespace

Scenario read_scenario(config::ConfigReader& c, random::StudySeed seed) {
  Scenario s;
  s.seed = seed;
  s.trials = static_cast<std::uint64_t>(c.integer("trials", 1, 100'000'000));
  s.field = study::read_field(c);
  s.stations = static_cast<int>(c.integer("well.stations", 3, 100'000, 80));
  s.spacing = c.number("well.spacing_m", config::Range::positive(), 30);
  s.inclination_from = kDegree * c.number("well.inclination_from_deg", config::Range::closed(0, 180), 0);
  s.inclination_to = kDegree * c.number("well.inclination_to_deg", config::Range::closed(0, 180), 60);
  s.azimuth = kDegree * c.number("well.magnetic_azimuth_deg", config::Range::closed(0, 360), 60);
  s.noise = sensor_values(c, "noise", config::Range::positive(), 0.2, 20);
  s.walk = sensor_values(c, "walk", config::Range::positive(), 0.02, 2);
  s.scatter = {kMilliG * c.number("scatter.gravity_mg", config::Range::non_negative(), 0.1),
               c.number("scatter.total_nT", config::Range::non_negative(), 30),
               kDegree * c.number("scatter.dip_deg", config::Range::non_negative(), 0.05)};
  const std::string sensor = c.choice("drift.sensor", {kSensors.begin(), kSensors.end()});
  s.sensor = static_cast<int>(std::find(kSensors.begin(), kSensors.end(), sensor) - kSensors.begin());
  s.drift_at_td = monitoring::Vector6::Zero();
  s.drift_at_td[s.sensor] = s.sensor < 3 ? kMilliG * c.number("drift.at_td_mg", config::Range{})
                                         : c.number("drift.at_td_nT", config::Range{});
  s.from_station = static_cast<int>(c.integer("drift.from_station", 0, s.stations - 2, 20));
  s.sprt.shift = c.number("sprt.shift_sd", config::Range::positive(), 3);
  s.sprt.variance = 1;
  s.sprt.false_alarm = c.number("sprt.false_alarm", config::Range::open(0, 0.5), 1e-4);
  s.sprt.missed_alarm = c.number("sprt.missed_alarm", config::Range::open(0, 0.5), 0.10);
  s.alarm_sd = c.number("filter.alarm_sd", config::Range::positive(), 3);
  s.verdict.confidence = c.number("verdict.confidence", config::Range::open(0, 1), 0.95);
  s.verdict.margin = c.number("verdict.margin", config::Range::open(0, 1), s.verdict.margin);
  s.verdict.nees_margin = c.number("verdict.nees_margin", config::Range::open(0, 1), s.verdict.nees_margin);
  const std::vector<double> no_rows;
  const Outcomes none(no_rows);
  std::vector<study::RowName> names;
  for (const study::ComparisonRow& r : comparison_rows(s, none))
    names.push_back({"comparison", r.formulation, r.quantity});
  for (const study::ComparisonRow& r : claim_rows(s, none)) names.push_back({"claims", r.formulation, r.quantity});
  s.annotations = study::Annotations::read(c, names);
  c.finish();
  return s;
}

Run run_well(const Scenario& s, std::uint64_t trial, SensorBias kind, bool keep_stations) {
  const random::Stream stream = random::stream_of(s.seed);
  static const double inside = stats::chi_squared_quantile(3, 0.95);
  Run run;
  monitoring::BiasFilter filter(s.walk.cwiseAbs2());
  std::array<monitoring::Sprt, 3> sprt{monitoring::Sprt(s.sprt), monitoring::Sprt(s.sprt), monitoring::Sprt(s.sprt)};
  monitoring::Vector6 truth = monitoring::Vector6::Zero();
  const int alarms_from = kind == SensorBias::ramp ? s.from_station : 0;
  for (int k = 0; k < s.stations; ++k) {
    const auto station = static_cast<std::uint32_t>(k);
    const double toolface =
        2 * kPi * stream.uniforms<double>(trial, random::Channel::survey_toolface, station / 4)[station % 4];
    const survey::Attitude at{s.inclination(k), s.azimuth, toolface};
    monitoring::Vector6 readings;
    const survey::Vec3<double> u = survey::down_T(at), m = survey::magnetic_T(at, s.field.total, s.field.dip);
    const double gravity = s.field.gravity;
    readings << gravity * u.x, gravity * u.y, gravity * u.z, m.x, m.y, m.z;
    if (kind == SensorBias::ramp) truth = s.ramp(k) * s.drift_at_td;
    if (kind == SensorBias::walk)
      for (int j = 0; j < 6; ++j) truth[j] += s.walk[j] * sensor_draw(stream, trial, kFirstStep, k, j);
    for (int j = 0; j < 6; ++j) readings[j] += s.noise[j] * sensor_draw(stream, trial, 0, k, j) + truth[j];
    Vector3d reference(s.field.gravity, s.field.total, s.field.dip);
    for (int i = 0; i < 3; ++i)
      reference[i] += s.scatter[i] * stream.normal(trial, random::Channel::survey_reference,
                                                   4 * station + static_cast<std::uint32_t>(i));

    const Vector3d g = readings.head<3>(), b = readings.tail<3>();
    const monitoring::ChannelJacobian h = monitoring::survey_channel_jacobian(g, b);
    const Eigen::Matrix3d r = h * monitoring::Matrix6(s.noise.cwiseAbs2().asDiagonal()) * h.transpose() +
                              Eigen::Matrix3d(s.scatter.cwiseAbs2().asDiagonal());
    const Vector3d y = monitoring::survey_channels(g, b) - reference;
    const double nis = filter.update(y, h, r);
    run.nis_mean += nis / s.stations;
    run.nis_inside += (nis <= inside ? 1.0 : 0.0) / s.stations;
    run.nees_mean += monitoring::normalised_error(filter.bias() - truth, filter.covariance()) / s.stations;

    DriftingStation seen;
    seen.channels = y.cwiseQuotient(r.diagonal().cwiseSqrt());
    for (std::size_t i = 0; i < 3; ++i) {
      if (sprt[i].update(seen.channels[static_cast<Eigen::Index>(i)]) != 0 && run.sprt_alarm < 0 && k >= alarms_from)
        run.sprt_alarm = k;
      seen.sprt[i] = sprt[i].decision();
    }
    seen.truth = truth;
    seen.bias = filter.bias();
    seen.sd = filter.covariance().diagonal().cwiseSqrt();
    Eigen::Index largest = 0;
    const double ratio = seen.bias.cwiseQuotient(seen.sd).cwiseAbs().maxCoeff(&largest);
    if (ratio >= s.alarm_sd) seen.named = static_cast<int>(largest);
    if (seen.named >= 0 && run.filter_alarm < 0 && k >= alarms_from) {
      run.filter_alarm = k;
      run.named = seen.named;
    }
    if (keep_stations) run.stations.push_back(seen);
  }
  return run;
}

}  // namespace surveymc::studies::mwd_drift
