/// Operations of the kernels, counted and not timed: run with --benchmark_filter=count/ and read the counters.
#include "counted.h"

#include "bench_setup.h"
#include "survey/minimum_curvature.h"

namespace surveymc::bench {
namespace {

using C = Counted;

/// Counters: operations of one call of `f`, per item.
template <class F>
void count(benchmark::State& state, int items, F f) {
  operations = {};
  f();
  const Operations o = operations;
  for (auto _ : state) {
  }
  const double n = items;
  state.counters = {{"add", o.add / n},
                    {"multiply", o.multiply / n},
                    {"fma", o.fma / n},
                    {"divide", o.divide / n},
                    {"root", o.root / n},
                    {"compare", o.compare / n},
                    {"integer", o.integer / n},
                    {"integer_multiply", o.integer_multiply / n},
                    {"flop", (o.add + o.multiply + 2 * o.fma) / n}};
}

/// Data of trial t of a batch.
estimate::MsaData trial_data(Setup& s, int t) {
  const auto group = static_cast<std::size_t>(t / simd::kGroup);
  estimate::MsaData d = s.msa_data();
  d.magnetic += group * s.readings.magnetic.group_stride() + static_cast<std::size_t>(t % simd::kGroup);
  return d;
}

void normal(benchmark::State& state) {
  count(state, 4, [] {
    benchmark::DoNotOptimize(random::Stream(1, 1).normals<C>(CountedBits(7), random::Channel::magnetometer_noise, 3));
  });
}
BENCHMARK(normal)->Name("count/normal")->Iterations(1);

void sums(benchmark::State& state) {
  Setup s;
  count(state, s.survey.size(), [&] { benchmark::DoNotOptimize(estimate::msa_reading_sums<C>(trial_data(s, 0))); });
}
BENCHMARK(sums)->Name("count/msa_station_reading_sums")->Iterations(1);

template <bool WithMatrix>
void station(benchmark::State& state) {
  Setup s;
  const estimate::MsaReadingSums<C> once{};
  count(state, s.survey.size(), [&] {
    benchmark::DoNotOptimize(
        estimate::msa_normal_equations<C, WithMatrix>(trial_data(s, 0), once, {1, 1, 1, 0, 0, 0}, C(1)));
  });
}
BENCHMARK(station<true>)->Name("count/msa_station_with_matrix")->Iterations(1);
BENCHMARK(station<false>)->Name("count/msa_station_gradient_only")->Iterations(1);

template <bool Series>
void gradient_station(benchmark::State& state) {
  Setup s;
  count(state, s.survey.size(), [&] {
    benchmark::DoNotOptimize(estimate::msa_gradient<C, Series>(trial_data(s, 0), {1, 1, 1, 0, 0, 0}));
  });
}
BENCHMARK(gradient_station<false>)->Name("count/msa_station_gradient_exact")->Iterations(1);
BENCHMARK(gradient_station<true>)->Name("count/msa_station_gradient_by_series")->Iterations(1);

void factor_and_solve(benchmark::State& state) {
  count(state, 1, [] {
    simd::Symmetric<C, 6> m;
    for (std::size_t i = 0; i < 6; ++i) m[simd::packed(i, i)] = 1;
    benchmark::DoNotOptimize(simd::ldlt_solve<C, 6>(simd::ldlt<C, 6>(m), {1, 2, 3, 4, 5, 6}));
  });
}
BENCHMARK(factor_and_solve)->Name("count/msa_factor_and_solve")->Iterations(1);

/// Mean of the trials of a batch; iterations as in the benchmark msa_estimate.
template <bool WithExpansion>
void estimate(benchmark::State& state) {
  Setup s;
  count(state, s.trials, [&] {
    for (int t = 0; t < s.trials; ++t)
      benchmark::DoNotOptimize(
          estimate::msa_solve<C>(trial_data(s, t), WithExpansion ? &s.expansion : nullptr, s.options));
  });
}
BENCHMARK(estimate<true>)->Name("count/msa_estimate")->Iterations(1);
BENCHMARK(estimate<false>)->Name("count/msa_estimate_from_unit_gains")->Iterations(1);

/// Direction and leg of one station, without the correction of its reading (3 add, 3 multiply).
void position(benchmark::State& state) {
  count(state, 1, [] {
    const survey::Vec3<C> t =
        survey::tangent_from_fields(survey::Vec3<C>{0.1, 0.2, 0.9}, survey::Vec3<C>{0.3, 0.4, 0.5});
    const survey::Vec3<C> leg = survey::minimum_curvature_interval(C(30), t, t);
    benchmark::DoNotOptimize(leg + leg);
  });
}
BENCHMARK(position)->Name("count/position_station")->Iterations(1);

}  // namespace
}  // namespace surveymc::bench
