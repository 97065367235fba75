/// Multi-station analysis of any parameters: least squares and robust losses, readings given.
#include <random>
#include <string>

#include "bench_setup.h"
#include "multistation/robust.h"
#include "random/study_id.h"

namespace surveymc::bench {
namespace {

constexpr int kTrials = 64, kStations = 30;
constexpr double kGravity = 9.81;

/// Readings of a perfect tool, with the noise that the fit assumes: 70 nT, 0.006 m/s2.
multistation::SixAxisBlock noisy_readings(const Setup& s, const multistation::FitOptions& o) {
  std::mt19937 bits(1);
  std::normal_distribution<double> normal;
  multistation::SixAxisBlock b(kTrials, kStations);
  for (int g = 0; g < b.groups(); ++g)
    for (int lane = 0; lane < simd::kGroup; ++lane) {
      b.reference.row(g, 0)[lane] = kGravity;
      for (int i = 0; i < 2; ++i) b.reference.row(g, 1 + i)[lane] = s.readings.reference.row(g, i)[lane];
      for (int r = 0; r < 3 * kStations; ++r) {
        b.gravity.row(g, r)[lane] = kGravity * s.readings.down.row(g, r)[lane] + o.sizes[0] * normal(bits);
        b.magnetic.row(g, r)[lane] = s.readings.magnetic.row(g, r)[lane];
      }
    }
  return b;
}

/// Items: trials; counter: reweightings of a trial.
void robust(benchmark::State& state, multistation::Loss loss) {
  multistation::FitOptions o;
  o.parameters = multistation::ParameterSet::named(std::to_string(state.range(0)));
  const Setup s(kStations);
  const multistation::SixAxisBlock readings = noisy_readings(s, o);
  const multistation::FitPlan plan = multistation::fit_plan(o);
  multistation::RobustOptions robust{.loss = loss};
  if (loss == multistation::Loss::tukey) {
    robust.start = multistation::RobustStart::lmeds;
    robust.scale = multistation::RobustScale::start;
  }
  multistation::FitBlock out(kTrials, o);
  multistation::RobustBlock found(kTrials, kStations);
  const random::Stream stream(1, static_cast<std::uint32_t>(random::StudyId::robustness_map));
  time_calls(state, kTrials,
             [&] { multistation::robust_fit_block(readings, plan, o.parameters, robust, stream, 0, out, found); });
  double reweightings = 0;
  for (int t = 0; t < kTrials; ++t) reweightings += found.reweightings.value(t, 0);
  state.counters["reweightings"] = reweightings / kTrials;
}
BENCHMARK_CAPTURE(robust, l1, multistation::Loss::l1)->Arg(6)->Arg(12);
BENCHMARK_CAPTURE(robust, huber, multistation::Loss::huber)->Arg(6)->Arg(12);
BENCHMARK_CAPTURE(robust, cauchy, multistation::Loss::cauchy)->Arg(6)->Arg(12);
BENCHMARK_CAPTURE(robust, tukey, multistation::Loss::tukey)->Arg(6)->Arg(12);

/// Items: trials.
void multistation_fit(benchmark::State& state) {
  multistation::FitOptions o;
  o.parameters = multistation::ParameterSet::named(std::to_string(state.range(0)));
  const Setup s(kStations);
  const multistation::SixAxisBlock readings = noisy_readings(s, o);
  const multistation::FitPlan plan = multistation::fit_plan(o);
  multistation::FitBlock out(kTrials, o);
  time_calls(state, kTrials, [&] { multistation::fit_block(readings, plan, o.parameters, out); });
}
BENCHMARK(multistation_fit)->Arg(6)->Arg(12)->Arg(18);

}  // namespace
}  // namespace surveymc::bench
