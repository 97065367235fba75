#include "reliability/shots_lanes.h"

namespace surveymc::reliability::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

void put_shots(const ShotsModel& m, const ShotsTests<T>& t, bool with_base, double* out) {
  const std::size_t n = m.observations();
  for (std::size_t o = 0; o < n; ++o) store(out + o * kGroup, t.w[o]);
  store(out + n * kGroup, t.omega);
  store(out + (n + 1) * kGroup, t.largest);
  store(out + (n + 2) * kGroup, t.converged);
  if (!with_base) return;
  for (std::size_t i = 0; i < n * m.unknowns(); ++i) store(out + (n + 3 + i) * kGroup, t.base[i]);
}

}  // namespace

void shots_trials(const ShotsBatch& b) {
  const std::size_t n = b.model.observations(), readings = n - 3, tests = n + 3, all = tests + n * b.model.unknowns();
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < kGroup; lane += lane_count<T>) {
      const Bits<T> trial = consecutive<T>(b.first_trial + group * kGroup + lane);
      T y[kMostShotObservations], disturbed[kMostShotObservations];
      for (std::size_t o = 0; o < n; o += 4) {
        const std::array<T, 4> z =
            b.stream.normals<T>(trial, random::Channel::gross_error_study, static_cast<std::uint32_t>(o / 4));
        for (std::size_t i = o; i < o + 4 && i < n; ++i) {
          y[i] = fma(T(b.model.sd[i]), z[i - o], T(b.truth[i]));
          disturbed[i] = y[i] + T(b.error[i]);
        }
      }
      ShotsTests<T> t;
      adjust_and_test_shots<T>(b.model, y, {y[readings], y[readings + 1], y[readings + 2]}, t);
      put_shots(b.model, t, false, b.without + group * tests * kGroup + lane);
      adjust_and_test_shots<T>(b.model, disturbed,
                               {disturbed[readings], disturbed[readings + 1], disturbed[readings + 2]}, t);
      put_shots(b.model, t, true, b.with + group * all * kGroup + lane);
    }
}

}  // namespace surveymc::reliability::SURVEYMC_ISA
