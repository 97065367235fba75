/// What one core can do at most: the scale for all other numbers.
#include "bench_setup.h"

namespace surveymc::bench {
namespace {

/// Cycles per second: a chain of integer products, each 3 cycles after the one before on every processor since 2008.
void clock_rate(benchmark::State& state) {
  constexpr int count = 1000;
  std::uint64_t x = 3;
  time_calls(state, 3 * count, [&] {
    for (int i = 0; i < count; ++i) asm volatile("imul %0, %0" : "+r"(x));
  });
}
BENCHMARK(clock_rate);

constexpr int kRounds = 1000;

/// Items: floating-point operations.
void fma_rate(benchmark::State& state, simd::InstructionSet set) {
  time_calls(state, 2 * kRounds * Ceilings::kPerRound * ceilings(set).lanes,
             [&] { ceilings(set).fused_multiply_add(kRounds); });
}
const bool fma_registered = on_both("ceiling/fma_flops", fma_rate);

/// Items: operations on one double (or integer).
template <void (*Ceilings::*Kernel)(int)>
void at_once(benchmark::State& state, simd::InstructionSet set) {
  time_calls(state, kRounds * Ceilings::kPerRound * ceilings(set).lanes, [&] { (ceilings(set).*Kernel)(kRounds); });
}
const bool mixed_registered = on_both("ceiling/fma_and_add", at_once<&Ceilings::fused_and_add>);
const bool divide_registered = on_both("ceiling/divide", at_once<&Ceilings::divide>);
const bool root_registered = on_both("ceiling/square_root", at_once<&Ceilings::square_root>);
const bool integer_registered = on_both("ceiling/multiply_integers", at_once<&Ceilings::multiply_integers>);

/// Argument: KiB. 16 stay in the first-level cache, 512 in the second, 256 MiB in neither nor the third.
void load_bandwidth(benchmark::State& state, simd::InstructionSet set) {
  const auto n = static_cast<std::size_t>(state.range(0)) * 1024 / sizeof(double);
  survey::LaneArray data(1, static_cast<int>(n) / simd::kGroup);
  const int repeat = std::max(1, static_cast<int>((std::size_t{1} << 20) / n));
  for (auto _ : state)
    for (int i = 0; i < repeat; ++i) ceilings(set).load_all(data.row(0, 0), n);
  state.SetBytesProcessed(state.iterations() * repeat * static_cast<std::int64_t>(n * sizeof(double)));
}
const bool load_registered = on_both("ceiling/load_KiB", load_bandwidth, {16, 512, 256 * 1024});

/// a = b + s c, 128 MiB each; 24 bytes counted per element as STREAM does.
void stream_triad(benchmark::State& state, simd::InstructionSet set) {
  constexpr std::size_t n = std::size_t{128} << 17;
  survey::LaneArray a(1, n / simd::kGroup), b(1, n / simd::kGroup), c(1, n / simd::kGroup);
  for (auto _ : state) {
    ceilings(set).triad(a.row(0, 0), b.row(0, 0), c.row(0, 0), n);
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(3 * n * sizeof(double)));
}
const bool triad_registered = on_both("ceiling/dram_triad", stream_triad);

}  // namespace
}  // namespace surveymc::bench
