#include "reliability/gross_error_lanes.h"

namespace surveymc::reliability::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

void put(const StationTests<T>& t, double* out) {
  for (std::size_t o = 0; o < kStationObservations; ++o) store(out + o * kGroup, t.w[o]);
  store(out + kOmegaRow * kGroup, t.omega);
  store(out + kLargestRow * kGroup, t.largest);
  store(out + kTiedRow * kGroup, t.tied);
  store(out + kConvergedRow * kGroup, t.converged);
}

}  // namespace

void gross_error_trials(const GrossErrorBatch& b) {
  for (int group = 0; group < b.groups; ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<T>) {
      const Bits<T> trial = consecutive<T>(b.first_trial + static_cast<std::uint64_t>(group * kGroup + lane));
      std::array<T, kStationObservations> y, disturbed;
      for (std::uint32_t call = 0; call < 3; ++call) {
        const std::array<T, 4> z = b.stream.normals<T>(trial, random::Channel::gross_error_study, call);
        for (std::size_t i = 0; i < 4 && 4 * call + i < kStationObservations; ++i) {
          const std::size_t o = 4 * call + i;
          y[o] = fma(T(b.scale.sd[o]), z[i], T(b.truth[o]));
          disturbed[o] = y[o] + T(b.error[o]);
        }
      }
      const int at = group * kTestRows * kGroup + lane;
      put(adjust_and_test<T>(b.scale, y), b.without + at);
      put(adjust_and_test<T>(b.scale, disturbed), b.with + at);
    }
}

}  // namespace surveymc::reliability::SURVEYMC_ISA
