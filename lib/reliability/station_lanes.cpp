#include "reliability/station_lanes.h"

#include "simd/store_ahead.h"

namespace surveymc::reliability::SURVEYMC_ISA {

using namespace simd;
using simd::store;
using simd::store_ahead;
namespace {

using T = Lanes;

StationVariancesOf<T> wide(const StationVariances& v) {
  return {v.g_noise, v.g_bias,  v.g_scale,     v.b_noise, v.b_bias,   v.bz_bias,
          v.b_scale, v.gravity, v.total_field, v.dip,     v.stations, v.lambda0};
}

constexpr std::size_t kAttitudeQuantities = 5;  ///< the first ones: all but the effects on the references

/// `kPlain`: every observation that is wanted has these quantities and no others, so that no output has to be asked
/// for, and outputs are long columns.
template <StationModel kModel, bool kPlain>
void run_points(const StationBatch& b, unsigned wanted, bool reference_effects) {
  const StationVariancesOf<T> variances = wide(b.variances);
  T units[9][kMapQuantities];
  for (std::size_t o = 0; o < 9; ++o)
    for (std::size_t q = 0; q < kMapQuantities; ++q) units[o][q] = T(b.units[o][q]);
  for (std::size_t at = 0; at < static_cast<std::size_t>(b.groups) * kGroup; at += lane_count<T>) {
    const auto in = [&](std::size_t k) { return load<T>(b.points[k] + at); };
    const StationSines<T> s{in(0), in(1), in(2), in(3), in(4), in(5), in(6), in(7)};
    station_reliability<T, kModel>(
        s, in(8), variances, wanted, !kPlain && reference_effects,
        T(b.angle_unit), [&](std::size_t o, const ObservationReliability<T>& r) __attribute__((always_inline)) {
          const T values[kMapQuantities] = {r.redundancy, r.detectable, r.inclination, r.toolface,
                                            r.azimuth,    r.gravity,    r.total_field, r.dip};
          for (std::size_t q = 0; q < (kPlain ? kAttitudeQuantities : kMapQuantities); ++q) {
            double* out = b.outputs[o][q];
            if (!kPlain && !out) continue;
            // A redundancy number has no unit, and angles have theirs.
            const T value = q == 1 || q >= kAttitudeQuantities ? values[q] * units[o][q] : values[q];
            if constexpr (kPlain)
              store_ahead(out + at, value);
            else
              store(out + at, value);
          }
        });
  }
}

template <StationModel kModel>
void run(const StationBatch& b) {
  unsigned wanted = 0;
  bool reference_effects = false, plain = b.long_columns;
  for (std::size_t o = 0; o < 9; ++o) {
    std::size_t first = 0, others = 0;  // how many outputs of either kind
    for (std::size_t q = 0; q < kMapQuantities; ++q)
      (q < kAttitudeQuantities ? first : others) += b.outputs[o][q] != nullptr;
    if (first + others == 0) continue;
    wanted |= 1u << o;
    reference_effects |= others > 0;
    plain &= first == kAttitudeQuantities && others == 0;
  }
  if (plain)
    run_points<kModel, true>(b, wanted, false);
  else
    run_points<kModel, false>(b, wanted, reference_effects);
}

}  // namespace

void station_batch(StationKernel kernel, const StationBatch& b) {
  with_model(kernel, [&](auto model) { run<model.value>(b); });
}

}  // namespace surveymc::reliability::SURVEYMC_ISA
