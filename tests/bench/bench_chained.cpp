/// Chained multistation on lanes: smoother and filter, readings given, covariances of all stations included.
#include <cmath>

#include "bench_setup.h"
#include "chained/batch.h"
#include "chained/block_solver.h"
#include "chained/mode_search.h"
#include "chained_cases.h"

namespace surveymc::bench {
namespace {

constexpr int kTrials = 64;

/// Slide 7, with walks that reach as far in `stations` as in 18: the estimation problem stays the same.
chained::Model model_of(int stations) {
  chained::ChainSizes s = chained_case::slide7_sizes();
  for (chained::ChainSize* size :
       {&s.accelerometer_xy, &s.accelerometer_z, &s.magnetometer_xy, &s.magnetometer_z, &s.gravity, &s.field})
    size->walk *= std::sqrt(18.0 / stations);
  return chained::make_model(s, stations, chained::ChainReferences::chained);
}

/// Items: runs; counters: stations a second, and passes to convergence.
void chained(benchmark::State& state, chained::Mode mode) {
  const int stations = static_cast<int>(state.range(0));
  const chained::Model m = model_of(stations);
  const chained_case::Runs in(chained_case::run_setup(m, chained_case::building_profile(stations)), kTrials,
                              random::Stream(1, 8));
  chained::BatchSolution out(kTrials, stations);
  time_calls(state, kTrials, [&] { chained::solve_batch(m, mode, in.batch, out); });
  state.counters["stations"] =
      benchmark::Counter(static_cast<double>(kTrials) * stations, benchmark::Counter::kIsIterationInvariantRate);
  double passes = 0;
  for (int t = 0; t < kTrials; ++t) passes += out.iterations(t);
  state.counters["passes"] = passes / kTrials;
}
BENCHMARK_CAPTURE(chained, smoother, chained::Mode::smoother)->Arg(18)->Arg(60)->Arg(200)->Arg(600)->Arg(2000);
BENCHMARK_CAPTURE(chained, filter, chained::Mode::filter)->Arg(18)->Arg(2000);

/// The block solver, one run at a time.
void newton(benchmark::State& state) {
  const int stations = static_cast<int>(state.range(0));
  const chained::Model m = model_of(stations);
  const chained::Readings readings =
      chained_case::drawn_readings(m, chained_case::building_profile(stations), random::Stream(1, 8), 0);
  time_calls(state, 1, [&] { return chained::solve_blocks(m, readings); });
}
BENCHMARK(newton)->Name("chained_newton")->Arg(18)->Arg(2000);

/// All minima of one run: three sub-searches, seven descents and the mirror image's, covariances. Items: runs.
void modes(benchmark::State& state) {
  const int stations = static_cast<int>(state.range(0));
  const chained::Model m = model_of(stations);
  const chained::Readings readings =
      chained_case::drawn_readings(m, chained_case::building_profile(stations), random::Stream(1, 8), 0);
  time_calls(state, 1, [&] { return chained::find_modes(m, readings); });
}
BENCHMARK(modes)->Name("chained_modes")->Arg(18)->Arg(100);

}  // namespace
}  // namespace surveymc::bench
