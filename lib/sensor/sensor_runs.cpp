#include "sensor/sensor_runs.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sensor/sensor_runs_lanes.h"
#include "simd/instruction_set.h"

namespace surveymc::sensor {

namespace {

bool draws_toolfaces(const survey::ToolfacePlan& plan) {
  return plan.has(survey::ToolfaceSource::slide) || plan.has(survey::ToolfaceSource::own);
}

}  // namespace

SensorRunSetup sensor_run_setup(const survey::Survey& survey, const survey::ReferenceField& field,
                                const survey::SensorTermArray& sd, const survey::ToolfacePlan& plan,
                                survey::PositionMethod method, const std::vector<int>& reported) {
  assert(plan.size() == survey.size());
  SensorRunSetup s;
  for (const survey::Station& station : survey.stations) {
    survey::Attitude at = survey::magnetic_attitude(station, field.declination);
    at.toolface = 0;
    s.gravity_H.push_back(scale(field.gravity, survey::down_T(at)));
    s.field_H.push_back(survey::magnetic_T(at, field.total, field.dip));
  }
  s.md = survey.md();
  s.declination = field.declination;
  s.method = method;
  s.sd = sd;
  s.plan = plan;
  s.reported = reported;
  return s;
}

SensorRuns::SensorRuns(int trial_count, const SensorRunSetup& setup)
    : trials(trial_count),
      errors(survey::groups_for(trial_count), survey::kSensorTerms),
      toolface(survey::groups_for(trial_count), 2 * setup.stations(), !draws_toolfaces(setup.plan)),
      positions(survey::groups_for(trial_count), 3 * static_cast<int>(setup.reported.size())) {}

namespace {

SensorRunBatch batch_of(const SensorRunSetup& s, SensorRuns& runs) {
  return {&s.gravity_H.front().x,
          &s.field_H.front().x,
          s.md.data(),
          s.plan.source.data(),
          nullptr,
          nullptr,
          s.plan.first_slid(),
          s.stations(),
          survey::groups_for(runs.trials),
          s.reported.data(),
          static_cast<int>(s.reported.size()),
          s.first_is_tie_on,
          s.method,
          std::sin(s.declination),
          std::cos(s.declination),
          s.sd,
          0,
          runs.errors.row(0, 0),
          runs.toolface.row(0, 0),
          runs.positions.row(0, 0),
          runs.errors.group_stride(),
          runs.toolface.group_stride(),
          runs.positions.group_stride()};
}

}  // namespace

void draw_runs(const SensorRunSetup& setup, const random::Stream& stream, std::uint64_t first_trial, SensorRuns& runs) {
  assert(first_trial % simd::kGroup == 0);
  std::vector<double> cosines, sines;
  for (const double t : setup.plan.given) {
    cosines.push_back(std::cos(t));
    sines.push_back(std::sin(t));
  }
  SensorRunBatch batch = batch_of(setup, runs);
  batch.first_trial = first_trial;
  batch.given_cos = cosines.data();
  batch.given_sin = sines.data();
  simd::run_kernel<isa_v3::draw_sensor_runs, isa_v4::draw_sensor_runs>(batch, stream);
}

void run_positions(const SensorRunSetup& setup, SensorRuns& runs) {
  const SensorRunBatch batch = batch_of(setup, runs);
  simd::run_kernel<isa_v3::sensor_run_positions, isa_v4::sensor_run_positions>(batch);
}

void for_each_batch(const SensorRunSetup& setup, const random::Stream& stream, std::uint64_t first_trial, int count,
                    const std::function<void(std::uint64_t, const SensorRuns&)>& use) {
  const std::size_t rows = survey::kSensorTerms + 3 * setup.reported.size() +
                           (draws_toolfaces(setup.plan) ? 2 * static_cast<std::size_t>(setup.stations()) : 0);
  const auto fitting = static_cast<int>(65536 / (rows * sizeof(double)));
  const int batch = std::max(simd::kGroup, fitting / simd::kGroup * simd::kGroup);
  SensorRuns runs(std::min(batch, count), setup);
  for (int begin = 0; begin < count; begin += batch) {
    const int trials = std::min(batch, count - begin);
    if (trials != runs.trials) runs = SensorRuns(trials, setup);
    const std::uint64_t first = first_trial + static_cast<std::uint64_t>(begin);
    draw_runs(setup, stream, first, runs);
    run_positions(setup, runs);
    use(first, runs);
  }
}

SensorRuns runs_around(const SensorRunSetup& setup, const random::Stream& stream, std::uint64_t trial) {
  SensorRuns runs(simd::kGroup, setup);
  draw_runs(setup, stream, trial / simd::kGroup * simd::kGroup, runs);
  run_positions(setup, runs);
  return runs;
}

std::vector<double> toolfaces_of_trial(const survey::ToolfacePlan& plan, const random::Stream& stream,
                                       std::uint64_t trial) {
  std::vector<double> t = plan.given;
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (plan.source[k] == survey::ToolfaceSource::given) continue;
    const auto index = static_cast<std::uint32_t>(plan.source[k] == survey::ToolfaceSource::own ? static_cast<int>(k)
                                                                                                : plan.first_slid());
    t[k] = 2 * kPi * stream.uniforms<double>(trial, random::Channel::toolface, index / 4)[index % 4];
  }
  return t;
}

}  // namespace surveymc::sensor
