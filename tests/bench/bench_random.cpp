/// Random numbers and simulated readings.
#include "bench_setup.h"

namespace surveymc::bench {
namespace {

/// Items: normals.
void normals(benchmark::State& state, simd::InstructionSet set) {
  constexpr std::uint32_t calls = 40;  // as many as a trial of 53 stations
  const random::Stream stream(1, 1);
  survey::LaneArray out(1, 4 * calls);
  time_calls(state, 4 * calls * simd::kGroup, [&] { kernels(set).normals(stream, calls, out.row(0, 0)); });
}
const bool normals_registered = on_both("normals", normals);

/// Items: trials of 53 stations.
template <bool WithSums>
void simulate(benchmark::State& state, simd::InstructionSet set) {
  Setup s;
  std::uint64_t first = 0;
  time_calls(state, s.trials, [&] {
    kernels(set).simulate(s.simulate_batch(first, WithSums));
    first += static_cast<std::uint64_t>(s.trials);
  });
}
const bool simulate_registered = on_both("simulate", simulate<false>);
const bool controlled_registered = on_both("simulate_with_control_variate", simulate<true>);

}  // namespace
}  // namespace surveymc::bench
