#include "analysis/drift_run.h"

#include <array>
#include <cmath>
#include <cstdint>

#include "base/units.h"
#include "random/study_stream.h"
#include "simd/instruction_set.h"
#include "stats/intervals.h"
#include "survey/frames.h"

namespace surveymc::analysis {
namespace {

using Eigen::Vector3d;

double nis_quantile() {
  static const double inside = stats::chi_squared_quantile(3, 0.95);
  return inside;
}

/// Normals of a trial by their index. Four neighbours come from one call of the generator, which takes as long as one.
class Draws {
 public:
  Draws(const random::Stream& stream, std::uint64_t trial, random::Channel channel)
      : stream_(stream), trial_(trial), channel_(channel) {}

  double operator[](std::uint32_t index) {
    if (const std::uint64_t call = index / 4; call != call_) {
      four_ = stream_.normals<double>(trial_, channel_, call);
      call_ = call;
    }
    return four_[index % 4];
  }

 private:
  const random::Stream& stream_;
  std::uint64_t trial_;
  random::Channel channel_;
  std::uint64_t call_ = ~std::uint64_t{0};
  std::array<double, 4> four_{};
};

}  // namespace

DriftRun drift_run(const DriftRunSetup& s, std::uint64_t trial, SensorBias kind, bool keep_stations) {
  const random::Stream stream = random::stream_of(s.seed);
  const double inside = nis_quantile();
  DriftRun run;
  monitoring::BiasFilter filter(s.walk.cwiseAbs2());
  std::array<monitoring::Sprt, 3> sprt{monitoring::Sprt(s.sprt), monitoring::Sprt(s.sprt), monitoring::Sprt(s.sprt)};
  monitoring::Vector6 truth = monitoring::Vector6::Zero();
  Draws noise(stream, trial, random::Channel::survey_sensor_noise),
      steps = noise, of_reference(stream, trial, random::Channel::survey_reference);
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
      for (int j = 0; j < 6; ++j)
        truth[j] += s.walk[j] * steps[kFirstDriftStep + 6 * station + static_cast<std::uint32_t>(j)];
    for (int j = 0; j < 6; ++j)
      readings[j] += s.noise[j] * noise[6 * station + static_cast<std::uint32_t>(j)] + truth[j];
    Vector3d reference(s.field.gravity, s.field.total, s.field.dip);
    for (int i = 0; i < 3; ++i)
      reference[i] += s.scatter[i] * of_reference[4 * station + static_cast<std::uint32_t>(i)];

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

DriftValues drift_values(const DriftRunSetup& s, std::uint64_t trial) {
  const DriftRun with = drift_run(s, trial, SensorBias::ramp), without = drift_run(s, trial, SensorBias::none),
                 walk = drift_run(s, trial, SensorBias::walk);
  const auto number = [](int station) { return static_cast<double>(station); };
  return {number(with.sprt_alarm),
          number(with.filter_alarm),
          number(with.named),
          number(without.sprt_alarm),
          number(without.filter_alarm),
          walk.nis_mean,
          walk.nis_inside,
          walk.nees_mean};
}

DriftBatch drift_batch(const DriftRunSetup& s, std::uint64_t first, std::vector<double>& columns) {
  const auto stations = static_cast<std::size_t>(s.stations);
  const double horizontal = s.field.total * std::cos(s.field.dip), vertical = s.field.total * std::sin(s.field.dip);
  columns.resize(5 * stations);
  double* column = columns.data();
  for (std::size_t k = 0; k < stations; ++k) {
    const double inclination = s.inclination(static_cast<int>(k)), si = std::sin(inclination),
                 ci = std::cos(inclination), north = horizontal * std::cos(s.azimuth);
    const std::array<double, 5> of_station{s.field.gravity * si, s.field.gravity * ci, north * ci - vertical * si,
                                           north * si + vertical * ci, s.ramp(static_cast<int>(k))};
    for (std::size_t c = 0; c < 5; ++c) column[c * stations + k] = of_station[c];
  }
  const auto six = [](const monitoring::Vector6& x) {
    return std::array<double, 6>{x[0], x[1], x[2], x[3], x[4], x[5]};
  };
  return {random::stream_of(s.seed),
          first,
          s.stations,
          s.from_station,
          column,
          column + stations,
          column + 2 * stations,
          column + 3 * stations,
          column + 4 * stations,
          horizontal * std::sin(s.azimuth),
          s.field.gravity,
          s.field.total,
          std::sin(s.field.dip),
          std::cos(s.field.dip),
          six(s.noise),
          six(s.drift_at_td),
          six(s.walk),
          {s.scatter[0], s.scatter[1], s.scatter[2]},
          s.sprt.shift / s.sprt.variance,
          s.sprt.shift / 2,
          monitoring::sprt_lower(s.sprt),
          monitoring::sprt_upper(s.sprt),
          s.alarm_sd,
          nis_quantile(),
          {},
          {}};
}

std::vector<DriftValues> drift_values(const DriftRunSetup& s, std::uint64_t first, int count) {
  std::vector<DriftValues> all(static_cast<std::size_t>(count));
  std::vector<double> columns;
  DriftBatch batch = drift_batch(s, first, columns);
  for (std::size_t at = 0; at < all.size(); at += simd::kGroup) {
    batch.first_trial = first + at;
    simd::run_kernel<isa_v3::drift_trials, isa_v4::drift_trials>(batch);
    for (std::size_t lane = 0; lane < simd::kGroup && at + lane < all.size(); ++lane) {
      if (batch.in_range[lane] == 0) {
        all[at + lane] = drift_values(s, first + at + lane);
        continue;
      }
      for (std::size_t v = 0; v < DriftResult::kValues; ++v) all[at + lane][v] = batch.values[v][lane];
    }
  }
  return all;
}

}  // namespace surveymc::analysis
