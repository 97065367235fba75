#include "propagate/hole_direction.h"

#include <cmath>

#include "error_model/model.h"

namespace surveymc::propagate {
namespace {

using Eigen::Vector3d;

Vector3d tangent(const survey::Station& s) {
  return survey::to_eigen(survey::tangent_N({s.inclination, s.azimuth, 0}));
}

/// The direction at the share `f` of the arc from t0 to t1.
Vector3d tangent_between(const Vector3d& t0, const Vector3d& t1, double f) {
  const double beta = 2 * std::atan2((t1 - t0).norm(), (t1 + t0).norm());
  constexpr double kStraight = 1e-8;  // below it the arc is its chord to the last bit
  if (beta < kStraight) return ((1 - f) * t0 + f * t1).normalized();
  return (std::sin((1 - f) * beta) * t0 + std::sin(f * beta) * t1) / std::sin(beta);
}

}  // namespace

double azimuth_of(const Vector3d& tangent, double listed) {
  if (std::hypot(tangent.x(), tangent.y()) > std::sin(error_model::kVerticalLimit))
    return std::atan2(tangent.y(), tangent.x());
  return listed;
}

HoleDirection hole_direction(const survey::Station& from, const survey::Station& to, double share) {
  if (share <= 0) return {from.inclination, from.azimuth};
  if (share >= 1) return {to.inclination, to.azimuth};
  const Vector3d t = tangent_between(tangent(from), tangent(to), share);
  return {std::atan2(std::hypot(t.x(), t.y()), t.z()), azimuth_of(t, from.azimuth)};
}

}  // namespace surveymc::propagate
