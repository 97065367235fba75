#include "estimate/msa_lanes.h"

namespace surveymc::estimate::SURVEYMC_ISA {

using namespace simd;
using simd::store;

void msa_solve_batch(const MsaBatch& b) {
  using T = Lanes;
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
      MsaData data = b.first;
      data.magnetic += group * b.magnetic_stride + static_cast<std::size_t>(lane);
      data.down += group * b.down_stride + static_cast<std::size_t>(lane);
      data.reference += group * b.reference_stride + static_cast<std::size_t>(lane);
      double* parameters = b.parameters + group * b.parameters_stride + lane;
      std::array<T, 6> x;
      for (std::size_t a = 0; b.goes_on && a < 3; ++a) {
        x[a] = T(1.0) / load<T>(parameters + a * kGroup);
        x[3 + a] = load<T>(parameters + (3 + a) * kGroup) * x[a] * T(1 / b.total);
      }
      const MsaSolution<T> s = b.goes_on     ? msa_solve_from<T>(x, data, b.options)
                               : b.valley    ? msa_solve_in_valley<T>(data, b.down_stride != 0, *b.valley, b.options)
                               : b.expansion ? msa_solve_near<T>(data, *b.expansion, b.options)
                                             : msa_solve<T>(data, b.options);
      for (int a = 0; a < 3; ++a) {
        const T gain = T(1.0) / s.x[static_cast<std::size_t>(a)];
        store(parameters + a * kGroup, gain);
        store(parameters + (3 + a) * kGroup, s.x[static_cast<std::size_t>(3 + a)] * gain * T(b.total));
      }
      const std::size_t at = group * b.scalar_stride + static_cast<std::size_t>(lane);
      store(b.cost + at, s.cost * T(b.total * b.total));
      store(b.iterations + at, s.iterations);
      store(b.converged + at, s.converged);
    }
}

}  // namespace surveymc::estimate::SURVEYMC_ISA
