#include "orders/order_needed.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace surveymc::orders {

OrderVerdict order_needed(const Moments& first, const Moments& second, const Profile& profile,
                          const Eigen::Vector3d& direction, double margin) {
  const auto sd_of = [&](const Moments& m) {
    return std::sqrt(std::max(0.0, direction.dot(m.covariance * direction)));
  };
  const double sd_first = sd_of(first), sd_second = sd_of(second);
  const Shape shape = shape_along(profile.mixture, direction), coarse = shape_along(profile.coarse, direction);
  OrderVerdict v;
  // What first order leaves at rest but for rounding: the vertical of a plane well.
  const bool is_moved = sd_first > 1e-9 * std::sqrt(first.covariance.trace());
  v.e2 = is_moved ? sd_second / sd_first - 1 : kInfinity;
  v.m2 = is_moved ? direction.dot(second.mean - first.mean) / sd_first : kInfinity;
  v.e4 = shape.sd / sd_second - 1;
  v.remainder = coarse.sd / shape.sd - 1;
  v.kurtosis = shape.kurtosis;
  for (const Jump& j : profile.jumps)
    if (std::abs(j.from) < kJumpReach && std::abs(direction.dot(j.leap)) > shape.sd &&
        (!v.jump || j.probability > v.jump->probability))
      v.jump = j;
  const double half = margin / 2;
  const bool is_fourth_small = std::abs(v.e4) < half;
  if (!v.jump && std::abs(v.e2) < half && std::abs(v.m2) < 0.1 && is_fourth_small)
    v.order = Order::first;
  else if (!v.jump && is_fourth_small && std::abs(v.kurtosis - 3) < 0.5)
    v.order = Order::second;
  else
    v.order = std::abs(v.remainder) < half ? Order::profile : Order::sample;
  return v;
}

}  // namespace surveymc::orders
