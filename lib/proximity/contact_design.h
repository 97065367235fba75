#pragma once
/// The nearest way from two wells as surveyed to two wells that touch, to first order: over all pairs of points of
/// their paths, the least length of the standard normals that bring them within R of each other.
///
/// For a pair, r = offset - reference and C the relative covariance, C = V diag(w) V', c = V'r:
///   q_i = c_i / (1 + l w_i), l > 0 with |q| = R,   beta^2 = sum (c_i - q_i)^2 / w_i
/// With J (3 x n) the derivative of r by every normal, C = J J', the design point is z = -J' C^-1 (r - V q). The
/// closest pair of points is not the one of least beta.
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "proximity/well_path.h"

namespace surveymc::proximity {

/// beta of one pair; 0 where |r| <= R, infinite where C does not reach: the inverse in its range. `q`, if not null: the
/// difference of the points that touch.
double touching_beta(const Eigen::Vector3d& r, const Eigen::Matrix3d& c, double radii, Eigen::Vector3d* q = nullptr);

/// z = -J' C^-1 (r - q), C = J J' (pseudo-inverse).
Eigen::VectorXd design_of(const Eigen::Matrix3Xd& j, const Eigen::Vector3d& r, const Eigen::Vector3d& q);

struct TouchingPair {
  PathPoint reference, offset;
  double beta = 0;
};

/// C_rel of two points, m2. Must be finite: without a covariance there is no most likely contact.
using RelativeCovariance = std::function<Eigen::Matrix3d(const PathPoint& reference, const PathPoint& offset)>;

/// The local minima of beta over both paths from their stations `first` on, each refined to kDepthError of measured
/// depth. They are sought from the stations, from points within legs longer than 50 m, and where the wells may pass
/// each other between such points that are far from touching: two minima within 25 m of both wells may count as one
/// there. Those within `keep` of the least, at most `most`, the least first; none where the wells cannot touch.
std::vector<TouchingPair> touching_pairs(const WellPath& reference, std::size_t first_reference, const WellPath& offset,
                                         std::size_t first_offset, const RelativeCovariance& covariance, double radii,
                                         double keep, int most);
inline constexpr double kDepthError = 0.01;  // m

}  // namespace surveymc::proximity
