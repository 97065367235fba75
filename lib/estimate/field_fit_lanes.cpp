#include "estimate/field_fit_lanes.h"

namespace surveymc::estimate::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

template <std::size_t N>
void solve_lanes(const FieldFitBatch& b, std::size_t group, std::size_t lane) {
  FieldFitData data = b.first;
  data.magnetic += group * b.magnetic_stride + lane;
  data.down += group * b.down_stride + lane;
  data.reference += group * b.reference_stride + lane;
  std::array<T, N> start;
  for (std::size_t i = 0; i < N; ++i) start[i] = T(i < 3 ? 1.0 : 0.0);
  const NewtonSolution<T, N> s = field_fit_solution<T, N>(b.model, data, start, b.options);

  double* parameters = b.parameters + group * b.parameters_stride + lane;
  for (std::size_t i = 0; i < 3; ++i) {
    const T gain = T(1.0) / s.x[i];
    store(parameters + i * kGroup, gain);
    store(parameters + (3 + i) * kGroup, s.x[3 + i] * gain * T(b.model.total));
  }
  if constexpr (N == 8) {
    const T bh = load<T>(data.reference), bv = load<T>(data.reference + kGroup);
    const T stretch = fma(s.x[6], T(b.model.total_sd * b.model.total) / sqrt(fma(bh, bh, bv * bv)), T(1.0));
    const auto [sine, cosine] = sincos(s.x[7] * T(b.model.dip_sd));
    double* reference = b.reference_estimate + group * b.reference_estimate_stride + lane;
    store(reference, stretch * fms(cosine, bh, sine * bv));
    store(reference + kGroup, stretch * fma(sine, bh, cosine * bv));
  }
  const std::size_t at = group * b.scalar_stride + lane;
  store(b.cost + at, s.cost * T(b.model.total * b.model.total));
  store(b.iterations + at, s.iterations);
  store(b.converged + at, select((T(0.0) < s.converged) & are_sound(s.x), T(1.0), T(0.0)));
}

}  // namespace

void field_fit_batch(const FieldFitBatch& b) {
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>)
      if (b.model.joint)
        solve_lanes<8>(b, group, lane);
      else
        solve_lanes<6>(b, group, lane);
}

}  // namespace surveymc::estimate::SURVEYMC_ISA
