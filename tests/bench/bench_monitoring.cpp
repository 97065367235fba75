/// AAKR at the size of the published monitors: 1350 memory vectors of 4 sensors.
#include <random>

#include "bench_setup.h"
#include "monitoring/aakr.h"
#include "monitoring/aakr_lanes.h"

namespace surveymc::bench {
namespace {

/// Readings of four gauges that one rate drives, with noise of 0.3 of their spread: as the gas-lift well's, in z.
monitoring::Samples gauges(Eigen::Index count, std::mt19937_64& g) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> rate(-1.7, 1.7);
  monitoring::Samples x(count, 4);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double r = rate(g);
    for (Eigen::Index j = 0; j < 4; ++j) x(i, j) = .96 * (j == 0 ? -r : r) + .29 * normal(g);
  }
  return x;
}

/// Items: samples predicted. range(0): the bandwidth h in percent of z; how many vectors are left out depends on it.
void aakr(benchmark::State& state, simd::InstructionSet set) {
  constexpr int kQueries = 64;
  std::mt19937_64 g(1);
  const monitoring::Aakr model(gauges(1350, g), .01 * static_cast<double>(state.range(0)));
  const monitoring::Samples queries = gauges(kQueries, g);
  monitoring::Samples out(kQueries, 4);
  std::vector<double> nearest(kQueries), scratch;
  const monitoring::AakrBatch batch = model.batch(queries.data(), kQueries, out.data(), nearest.data(), scratch);
  time_calls(state, kQueries, [&] {
    set == simd::InstructionSet::v4 ? monitoring::isa_v4::aakr_predict(batch) : monitoring::isa_v3::aakr_predict(batch);
  });
}
const bool aakr_registered = on_both("aakr_1350x4", aakr, {10, 20, 50});

}  // namespace
}  // namespace surveymc::bench
