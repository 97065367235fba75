#pragma once
/// Direction of the hole between two stations.
#include <Eigen/Core>

#include "survey/survey.h"

namespace surveymc::propagate {

/// Azimuth of a tangent (N, E, V), rad; `listed` where the hole is vertical there (below kVerticalLimit), so that a
/// direction about it means what the survey says.
double azimuth_of(const Eigen::Vector3d& tangent, double listed);

/// rad, true north.
struct HoleDirection {
  double inclination = 0, azimuth = 0;
};
/// The direction at `share` [0, 1] of the arc of minimum curvature from one station to the next, which the hole turns
/// along at a constant rate: t = (sin((1 - share) beta) t0 + sin(share beta) t1) / sin beta. At a station it is that
/// listed; where the arc is vertical, its azimuth is the one listed at `from`.
HoleDirection hole_direction(const survey::Station& from, const survey::Station& to, double share);

}  // namespace surveymc::propagate
