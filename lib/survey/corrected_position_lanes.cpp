#include "survey/corrected_position_lanes.h"

#include "survey/minimum_curvature.h"

namespace surveymc::survey::SURVEYMC_ISA {

using namespace simd;
using simd::store;
namespace {

Vec3<Lanes> load3(const double* p) { return {load<Lanes>(p), load<Lanes>(p + kGroup), load<Lanes>(p + 2 * kGroup)}; }

/// Directions of the hole from the readings of a run, station after station.
struct CorrectedRun {
  const double *magnetic, *down;
  Vec3<Lanes> p, bias;

  CorrectedRun(const double* magnetic_rows, const double* down_rows, const double* parameters)
      : magnetic(magnetic_rows), down(down_rows), bias(load3(parameters + 3 * kGroup)) {
    const Vec3<Lanes> gain = load3(parameters);
    p = {Lanes(1.0) / gain.x, Lanes(1.0) / gain.y, Lanes(1.0) / gain.z};
  }
  Vec3<Lanes> next() {
    const Vec3<Lanes> m = load3(magnetic), u = load3(down);
    magnetic += 3 * kGroup;
    down += 3 * kGroup;
    return tangent_from_fields(u, Vec3<Lanes>{(m.x - bias.x) * p.x, (m.y - bias.y) * p.y, (m.z - bias.z) * p.z});
  }
};

Vec3<Lanes> final_position(CorrectedRun run, const CorrectedPositionBatch& batch) {
  using T = Lanes;
  Vec3<T> position{T(0.0), T(0.0), T(0.0)}, before{};
  for (int k = 0; k < batch.stations; ++k) {
    const Vec3<T> t = run.next();
    if (k > 0) position = position + minimum_curvature_interval(T(batch.md[k] - batch.md[k - 1]), before, t);
    before = t;
  }
  return position;
}

Vec3<Lanes> constant(const double* v) { return {Lanes(v[0]), Lanes(v[1]), Lanes(v[2])}; }

Vec3<Lanes> tied_position(CorrectedRun run, const TiedPositionBatch& b, double* lateral) {
  using T = Lanes;
  const double* md = b.readings.md;
  Vec3<T> position{T(0.0), T(0.0), T(0.0)}, before = constant(b.tangents);
  for (int k = 0; k < b.readings.stations; ++k) {
    const Vec3<T> t = run.next();
    position = position + minimum_curvature_interval(T(md[k + 1] - md[k]), before, t);
    if (k == 0 && b.first_leg_doubled)
      position = position + scale(T(0.5 * (md[1] - md[0])), t - constant(b.tangents + 3));
    store(lateral + k * kGroup, dot(t, constant(b.right + 3 * k)));
    before = t;
  }
  return position;
}

void store_true(const Vec3<Lanes>& position, const CorrectedPositionBatch& b, double* out) {
  // Position is linear in the tangents' horizontal parts, so north is turned once, at the end.
  const Vec3<Lanes> r = magnetic_to_true(position, b.sin_declination, b.cos_declination);
  store(out, r.x);
  store(out + kGroup, r.y);
  store(out + 2 * kGroup, r.z);
}

CorrectedRun run_at(const CorrectedPositionBatch& b, std::size_t group, int lane) {
  return {b.magnetic + group * b.magnetic_stride + lane, b.down + group * b.down_stride + lane,
          b.parameters + group * b.parameters_stride + lane};
}

}  // namespace

void corrected_positions(const CorrectedPositionBatch& b) {
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<Lanes>)
      store_true(final_position(run_at(b, group, lane), b), b, b.position + group * b.position_stride + lane);
}

void tied_positions(const TiedPositionBatch& batch) {
  const CorrectedPositionBatch& b = batch.readings;
  for (std::size_t group = 0; group < static_cast<std::size_t>(b.groups); ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<Lanes>)
      store_true(tied_position(run_at(b, group, lane), batch, batch.lateral + group * batch.lateral_stride + lane), b,
                 b.position + group * b.position_stride + lane);
}

}  // namespace surveymc::survey::SURVEYMC_ISA
