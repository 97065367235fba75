/// One core, thesis trajectory 4 (53 stations), 70 nT noise, no reference noise: items are trials unless it says so.
#include <benchmark/benchmark.h>

#include "estimate/estimator.h"
#include "sensor/magnetometer.h"
#include "survey/corrected_position.h"
#include "thesis_cases.h"

using namespace surveymc;

namespace {

constexpr int kTrials = 256;

struct Setup {
  test::ThesisCase c = test::thesis_case(4);
  NoiseModel noise{.magnetometer = 70};
  CleanReadings clean;
  ReadingBlock block;
  EstimateBlock estimates{kTrials};
  LaneArray position{groups_for(kTrials), 3};
  std::unique_ptr<Estimator> estimator;

  Setup() : clean(unit_gain_readings()), block(make_reading_block(kTrials, c.survey.size(), noise)) {
    EstimatorOptions options;
    options.step_tolerance = 1e-6;
    estimator = make_estimator(options, c.field);
    simulate(0);
  }
  CleanReadings unit_gain_readings() const { return clean_readings(c.survey, c.field, {}); }
  void simulate(std::uint64_t first) { simulate_readings(clean, c.field, noise, Stream(1, 1), first, block); }
};

void count_trials(benchmark::State& state) { state.SetItemsProcessed(state.iterations() * kTrials); }

void normals(benchmark::State& state) {
  const Stream stream(1, 1);
  std::uint32_t call = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(stream.normals<Lanes>(consecutive<Lanes>(0), Channel::magnetometer_noise, call++));
  state.SetItemsProcessed(state.iterations() * 4 * lane_count<Lanes>);
}
BENCHMARK(normals);

void simulate(benchmark::State& state) {
  Setup s;
  std::uint64_t first = 0;
  for (auto _ : state) s.simulate(first += kTrials);
  count_trials(state);
}
BENCHMARK(simulate);

void estimate(benchmark::State& state) {
  Setup s;
  for (auto _ : state) s.estimator->solve(s.block, s.estimates);
  count_trials(state);
}
BENCHMARK(estimate);

void corrected_position(benchmark::State& state) {
  Setup s;
  s.estimator->solve(s.block, s.estimates);
  const std::vector<double> md = s.c.survey.md();
  for (auto _ : state) corrected_final_positions(s.block, s.estimates.parameters, md, 0, s.position);
  count_trials(state);
}
BENCHMARK(corrected_position);

/// What a Monte-Carlo run of MSA costs: noise, estimate.
void whole_trial(benchmark::State& state) {
  Setup s;
  std::uint64_t first = 0;
  for (auto _ : state) {
    s.simulate(first += kTrials);
    s.estimator->solve(s.block, s.estimates);
  }
  count_trials(state);
}
BENCHMARK(whole_trial);

}  // namespace
