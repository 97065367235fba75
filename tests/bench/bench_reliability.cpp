/// Reliability maps: the kernel over a 181 x 181 grid, all observations and all external reliabilities.
#include "bench_setup.h"
#include "reliability/nonlinear_detectable.h"
#include "reliability/reliability_grid.h"
#include "reliability/significance.h"

namespace surveymc::bench {
namespace {

std::vector<double> degrees(double from, double step, int count) {
  std::vector<double> x;
  for (int i = 0; i < count; ++i) x.push_back(from + i * step);
  return x;
}

reliability::ReliabilityGrid map_181() { return {{1}, {75}, {30}, degrees(0, 1, 181), degrees(0, 1, 181)}; }

/// The kernel alone, points in the caches. Items: points, each with nine observations (sse) and eight quantities.
void kernel(benchmark::State& state, simd::InstructionSet set, reliability::StationKernel which) {
  constexpr int groups = 64;
  reliability::StationBatch b{};
  b.variances = {9.3e-8, 1.6e-7, 2.5e-7, 1.9e-6, 1.9e-6, 1.1e-5, 2.6e-6, 9.3e-8, 1.6e-6, 4.4e-6, 30, 4.56};
  std::vector<std::vector<double>> in(9, std::vector<double>(groups * simd::kGroup)), out(72, in[0]);
  for (std::size_t p = 0; p < in[0].size(); ++p) {
    const auto [sa, ca] = reliability::sincos_degrees(static_cast<double>(p % 180));
    const double values[9] = {0.5, 0.8660254037844386, 0.6, 0.8, sa, ca, 0.9659258262890683, 0.25881904510252074, 1};
    for (std::size_t k = 0; k < 9; ++k) in[k][p] = values[k];
  }
  for (std::size_t k = 0; k < 9; ++k) b.points[k] = in[k].data();
  const bool references = which != reliability::StationKernel::mse_fixed;
  for (std::size_t o = 0; o < (references ? 9u : 6u); ++o)
    for (std::size_t q = 0; q < reliability::kMapQuantities; ++q) {
      if (which == reliability::StationKernel::sse_axial && o == 5) continue;
      b.outputs[o][q] = out[8 * o + q].data();
      b.units[o][q] = 1;
    }
  b.groups = groups;
  b.angle_unit = 57;
  time_calls(state, groups * simd::kGroup, [&] {
    set == simd::InstructionSet::v4 ? reliability::isa_v4::station_batch(which, b)
                                    : reliability::isa_v3::station_batch(which, b);
  });
}
template <reliability::StationKernel kWhich>
void kernel_of(benchmark::State& state, simd::InstructionSet set) {
  kernel(state, set, kWhich);
}
const bool kernels_registered[] = {
    on_both("reliability_kernel/sse", kernel_of<reliability::StationKernel::sse>),
    on_both("reliability_kernel/sse_axial", kernel_of<reliability::StationKernel::sse_axial>),
    on_both("reliability_kernel/mse_fixed", kernel_of<reliability::StationKernel::mse_fixed>),
    on_both("reliability_kernel/mse_shared", kernel_of<reliability::StationKernel::mse_shared>),
    on_both("reliability_kernel/mse_systematic", kernel_of<reliability::StationKernel::mse_systematic>)};

/// A whole map into memory that is used again: sines, kernel, streamed columns. Items: points.
void map(benchmark::State& state) {
  reliability::AdjustmentModel model;
  const reliability::ReliabilityMaps maps(model, map_181(), reliability::lambda0({}));
  const std::vector<reliability::MapQuantity> five{
      reliability::MapQuantity::redundancy_number, reliability::MapQuantity::minimal_detectable_error,
      reliability::MapQuantity::external_inclination, reliability::MapQuantity::external_toolface,
      reliability::MapQuantity::external_azimuth};
  reliability::MapValues values;
  time_calls(state, static_cast<std::int64_t>(maps.grid().points()),
             [&] { maps.fill(reliability::observed(model.mode), five, 0, maps.grid().points(), values); });
}
BENCHMARK(map)->Name("reliability_map_181");

/// One nonlinear minimal detectable error. Items: errors.
void nonlinear(benchmark::State& state) {
  time_calls(state, 1, [] {
    return reliability::nonlinear_detectable_error({}, {0.5, 1.0, 0.8}, 3, reliability::lambda0({}), 1);
  });
}
BENCHMARK(nonlinear)->Name("reliability_nonlinear_error");

}  // namespace
}  // namespace surveymc::bench
