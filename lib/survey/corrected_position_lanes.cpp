#include "survey/corrected_position_lanes.h"

#include "survey/minimum_curvature.h"

namespace surveymc::survey::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

Vec3<Lanes> load3(const double* p) { return {load<Lanes>(p), load<Lanes>(p + kGroup), load<Lanes>(p + 2 * kGroup)}; }

Vec3<Lanes> final_position(const double* magnetic, const double* down, const double* parameters,
                           const CorrectedPositionBatch& batch) {
  using T = Lanes;
  const Vec3<T> gain = load3(parameters), bias = load3(parameters + 3 * kGroup);
  const Vec3<T> p{T(1.0) / gain.x, T(1.0) / gain.y, T(1.0) / gain.z};
  Vec3<T> position{T(0.0), T(0.0), T(0.0)}, before{};
  for (int k = 0; k < batch.stations; ++k, magnetic += 3 * kGroup, down += 3 * kGroup) {
    const Vec3<T> m = load3(magnetic), u = load3(down);
    const Vec3<T> b{(m.x - bias.x) * p.x, (m.y - bias.y) * p.y, (m.z - bias.z) * p.z};
    const Vec3<T> t = tangent_from_fields(u, b);
    if (k > 0) position = position + minimum_curvature_interval(T(batch.md[k] - batch.md[k - 1]), before, t);
    before = t;
  }
  return position;
}

}  // namespace

void corrected_positions(const CorrectedPositionBatch& b) {
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<Lanes>) {
      // Position is linear in the tangents' horizontal parts, so north is turned once, at the end.
      const Vec3<Lanes> r = magnetic_to_true(
          final_position(b.magnetic + group * b.magnetic_stride + lane, b.down + group * b.down_stride + lane,
                         b.parameters + group * b.parameters_stride + lane, b),
          b.sin_declination, b.cos_declination);
      double* out = b.position + group * b.position_stride + lane;
      store(out, r.x);
      store(out + kGroup, r.y);
      store(out + 2 * kGroup, r.z);
    }
}

}  // namespace surveymc::survey::SURVEYMC_ISA
