#include "survey/corrected_position.h"

namespace surveymc {
namespace {

template <class T>
Vec3<T> load3(const double* p) {
  return {load<T>(p), load<T>(p + kGroup), load<T>(p + 2 * kGroup)};
}

template <class T>
Vec3<T> final_position(const double* magnetic, const double* down, const double* parameters,
                       const std::vector<double>& md) {
  const Vec3<T> gain = load3<T>(parameters), bias = load3<T>(parameters + 3 * kGroup);
  const Vec3<T> p{T(1.0) / gain.x, T(1.0) / gain.y, T(1.0) / gain.z};
  Vec3<T> position{T(0.0), T(0.0), T(0.0)}, before{};
  for (std::size_t k = 0; k < md.size(); ++k) {
    const Vec3<T> m = load3<T>(magnetic + k * 3 * kGroup), u = load3<T>(down + k * 3 * kGroup);
    const Vec3<T> b{(m.x - bias.x) * p.x, (m.y - bias.y) * p.y, (m.z - bias.z) * p.z};
    const Vec3<T> t = tangent_from_fields(u, b);
    if (k > 0) position = position + minimum_curvature_leg(T(md[k] - md[k - 1]), before, t);
    before = t;
  }
  return position;
}

}  // namespace

void corrected_final_positions(const ReadingBlock& readings, const LaneArray& parameters, const std::vector<double>& md,
                               double declination, LaneArray& position) {
  // Position is linear in the tangents' horizontal parts, so north is turned once, at the end.
  const double sd = std::sin(declination), cd = std::cos(declination);
  for (int group = 0; group < readings.groups(); ++group)
    for (int lane = 0; lane < kGroup; lane += lane_count<Lanes>) {
      const Vec3<Lanes> r = magnetic_to_true(
          final_position<Lanes>(readings.magnetic.row(group, 0) + lane, readings.down.row(group, 0) + lane,
                                parameters.row(group, 0) + lane, md),
          sd, cd);
      store(position.row(group, 0) + lane, r.x);
      store(position.row(group, 1) + lane, r.y);
      store(position.row(group, 2) + lane, r.z);
    }
}

}  // namespace surveymc
