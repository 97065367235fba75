#include "survey/frames.h"

#include <Eigen/Geometry>

#include "base/units.h"

namespace surveymc::survey {

FieldFrame field_frame(const StationFields& station) {
  FieldFrame f;
  f.down = to_eigen(station.down_T);
  const Eigen::Vector3d b = to_eigen(station.field_T);
  f.vertical = f.down.dot(b);
  const Eigen::Vector3d h = b - f.vertical * f.down;
  f.horizontal = h.norm();
  f.north = h / f.horizontal;
  f.east = f.down.cross(f.north);
  return f;
}

Attitude attitude_from_fields(const Vec3<double>& g_T, const Vec3<double>& b_T) {
  const double cross_axis = std::hypot(g_T.x, g_T.y);
  Attitude at;
  at.inclination = std::atan2(cross_axis, g_T.z);
  if (cross_axis > 0) at.toolface = std::atan2(-g_T.x, -g_T.y);
  // From b_T's three rows (head of frames.h): well determined in a vertical hole too, where toolface is anything.
  const double st = std::sin(at.toolface), ct = std::cos(at.toolface);
  at.azimuth = std::atan2(b_T.x * ct - b_T.y * st,
                          std::cos(at.inclination) * (b_T.x * st + b_T.y * ct) + std::sin(at.inclination) * b_T.z);
  if (at.azimuth < 0) at.azimuth += 2 * kPi;
  if (at.toolface < 0) at.toolface += 2 * kPi;
  return at;
}

}  // namespace surveymc::survey
