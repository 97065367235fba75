#include "estimate/wls_lanes.h"

namespace surveymc::estimate::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

using T = Lanes;

void solve_lanes(const WlsBatch& b, std::size_t group, std::size_t lane) {
  const double* magnetic = b.magnetic + group * b.magnetic_stride + lane;
  const double* sd = b.assumed_sd ? b.assumed_sd + group * b.assumed_stride + lane : nullptr;
  const std::size_t at = group * b.parameters_stride + lane;
  const T variance(b.sd * b.sd);
  T cost(0.0);
  auto sound = T(0.0) < T(1.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // Normal equations in units of the assumed variance, biases in units of the total field.
    T ss(b.gain_weight * b.sd * b.sd), sb(0.0), bb(b.bias_weight[axis] * b.sd * b.sd * b.total * b.total), sy(0.0),
        by(0.0), yy(0.0);
    for (int k = 0; k < b.stations; ++k) {
      const std::size_t r = 3 * static_cast<std::size_t>(k) + axis;
      T w(1.0);
      if (sd) {
        const T own = load<T>(sd + r * kGroup);
        w = variance / (own * own);
      }
      const T h(b.truth[r]), dy = load<T>(magnetic + r * kGroup) - h, wh = w * h, wt = w * T(b.total);
      ss = fma(wh, h, ss);
      sb = fma(wt, h, sb);
      bb = fma(wt, T(b.total), bb);
      sy = fma(wh, dy, sy);
      by = fma(wt, dy, by);
      yy = fma(w * dy, dy, yy);
    }
    const T per_det = T(1.0) / fms(ss, bb, sb * sb);
    const T scale = fms(bb, sy, sb * by) * per_det, bias = fms(ss, by, sb * sy) * per_det;
    store(b.parameters + at + axis * kGroup, scale + T(1.0));
    store(b.parameters + at + (3 + axis) * kGroup, bias * T(b.total));
    store(b.claimed_variance + at + axis * kGroup, variance * bb * per_det);
    store(b.claimed_variance + at + (3 + axis) * kGroup, variance * ss * per_det * T(b.total * b.total));
    cost = cost + (yy - fma(scale, sy, bias * by));
    sound = sound & (abs(scale) < T(1e300)) & (abs(bias) < T(1e300));
  }
  const std::size_t scalar = group * b.scalar_stride + lane;
  store(b.cost + scalar, max(cost, T(0.0)));
  store(b.iterations + scalar, T(1.0));
  store(b.converged + scalar, select(sound, T(1.0), T(0.0)));
}

}  // namespace

void wls_batch(const WlsBatch& b) {
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(kGroup); lane += lane_count<T>)
      solve_lanes(b, group, lane);
}

}  // namespace surveymc::estimate::SURVEYMC_ISA
