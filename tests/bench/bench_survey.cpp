/// Forward model and positions.
#include "bench_setup.h"

namespace surveymc::bench {
namespace {

/// Items: stations.
void clean_readings_of_survey(benchmark::State& state) {
  const Setup s;
  time_calls(state, s.survey.size(), [&] { return sensor::clean_readings(s.survey, s.field, {}); });
}
BENCHMARK(clean_readings_of_survey)->Name("clean_readings");

/// Items: stations of one trial, each corrected and carried along by minimum curvature.
void corrected_position(benchmark::State& state, simd::InstructionSet set) {
  Setup s;
  time_calls(state, s.trials * s.survey.size(), [&] { kernels(set).corrected_positions(s.position_batch()); });
}
const bool position_registered = on_both("corrected_position", corrected_position);

}  // namespace
}  // namespace surveymc::bench
