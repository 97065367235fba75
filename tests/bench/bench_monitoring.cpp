/// AAKR at the size of the published monitors: 1350 memory vectors of 4 sensors.
#include <random>

#include "bench_setup.h"
#include "monitoring/aakr_lanes.h"

namespace surveymc::bench {
namespace {

/// Items: samples predicted.
void aakr(benchmark::State& state, simd::InstructionSet set) {
  constexpr std::size_t vectors = 1350, padded = 1352, sensors = 4, queries = 64;
  std::mt19937_64 g(1);
  std::normal_distribution<double> normal;
  std::vector<double> memory(padded * sensors), valid(padded, 1.0), query(queries * sensors), out(query),
      nearest(queries), scratch(padded);
  for (double& x : memory) x = normal(g);
  for (double& x : query) x = normal(g);
  for (std::size_t i = vectors; i < padded; ++i) valid[i] = 0;
  const monitoring::AakrBatch batch{.memory = memory.data(),
                                    .valid = valid.data(),
                                    .padded = padded,
                                    .sensors = sensors,
                                    .minus_half_per_h2 = -0.5 / (0.2 * 0.2),
                                    .queries = query.data(),
                                    .count = queries,
                                    .predictions = out.data(),
                                    .nearest = nearest.data(),
                                    .scratch = scratch.data()};
  for (auto _ : state) {
    if (set == simd::InstructionSet::v4)
      surveymc::monitoring::isa_v4::aakr_predict(batch);
    else
      surveymc::monitoring::isa_v3::aakr_predict(batch);
    benchmark::ClobberMemory();
  }
  count_items(state, queries);
}
const bool aakr_registered = on_both("aakr_1350x4", aakr);

}  // namespace
}  // namespace surveymc::bench
