#include "reliability/station_lanes.h"

namespace surveymc::reliability::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

template <StationModel kModel>
void run(const StationBatch& b) {
  using T = Lanes;
  unsigned wanted = 0;
  bool reference_effects = false;
  for (std::size_t o = 0; o < 9; ++o)
    for (std::size_t q = 0; q < kMapQuantities; ++q)
      if (b.outputs[o][q]) {
        wanted |= 1u << o;
        reference_effects |= q >= 5;
      }
  for (std::size_t at = 0; at < static_cast<std::size_t>(b.groups) * kGroup; at += lane_count<T>) {
    const auto in = [&](std::size_t k) { return load<T>(b.points[k] + at); };
    const StationSines<T> s{in(0), in(1), in(2), in(3), in(4), in(5), in(6), in(7)};
    station_reliability<T, kModel>(
        s, in(8), b.variances, wanted,
        reference_effects, [&](std::size_t o, const ObservationReliability<T>& r) __attribute__((always_inline)) {
          const T values[kMapQuantities] = {r.redundancy, r.detectable, r.inclination, r.toolface,
                                            r.azimuth,    r.gravity,    r.total_field, r.dip};
          for (std::size_t q = 0; q < kMapQuantities; ++q)
            if (double* out = b.outputs[o][q])  // a redundancy number has no unit
              store(out + at, q == 0 ? values[q] : values[q] * T(b.units[o][q]));
        });
  }
}

}  // namespace

void station_batch(StationKernel kernel, const StationBatch& b) {
  switch (kernel) {
    case StationKernel::sse:
      return run<kSseModel>(b);
    case StationKernel::sse_axial:
      return run<kSseAxialModel>(b);
    case StationKernel::mse_fixed:
      return run<kMseFixedModel>(b);
    case StationKernel::mse_shared:
      return run<kMseSharedModel>(b);
    case StationKernel::mse_systematic:
      return run<kMseSystematicModel>(b);
  }
}

}  // namespace surveymc::reliability::SURVEYMC_ISA
