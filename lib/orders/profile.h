#pragma once
/// The profile: F exactly along the one direction of the normals that dominates, the rest to first order around it.
///
/// v is the gradient of the longest horizontal axis a of the first-order covariance, v = J'a / |J'a|. With t = v'z
///   F(z) = F(t v) + J(t) (1 - v v') z + (tr H(t) - v'H(t) v) / 2
/// t on a fixed grid with the weights of a normal; J and H at a few nodes, and linear between them. Beyond the
/// outermost node they keep its value: nothing is extrapolated. A node beyond a fold of F has a wild J: it is left out
/// where its variance is above 50 times the median of all. To the covariance of the rest comes what its curvature adds,
/// tr(H_a H_b) / 2 at t = 0. The result is a mixture of normals with centres F(t v): it has skewness, kurtosis,
/// quantiles and coverage, and the jumps of F, where an estimate goes over to another minimum.
#include "orders/mixture.h"

namespace surveymc::orders {

struct ProfileOptions {
  int grid = 241;  ///< points of t in [-6, 6]
  int nodes = 9;   ///< of J and H, in [-4, 4]
};
inline constexpr double kGridReach = 6, kNodeReach = 4, kWildVariance = 50;

/// F leaps between two neighbouring points of the grid.
struct Jump {
  double from = 0, to = 0;                         ///< t, from nearer to the centre
  Eigen::Vector3d leap = Eigen::Vector3d::Zero();  ///< F beyond less F before, m
  /// Of a run beyond it: the tail of the normal from the middle of the two points on.
  double probability = 0;
};

struct Profile {
  Eigen::VectorXd direction;    ///< v; zero where nothing moves the position
  Eigen::Vector3d axis;         ///< a, N, E, 0
  std::vector<double> t;        ///< of the points that have a value
  Eigen::Matrix3Xd path;        ///< F(t v), m
  std::vector<double> weights;  ///< of these points; their sum is 1
  Mixture mixture;              ///< a part for every point
  Mixture coarse;               ///< the same by every other node: what it differs by is the remainder
  std::vector<Jump> jumps;      ///< by rising t
  int nodes_left_out = 0;       ///< as wild
  int points_left_out = 0;      ///< without a value
};

/// The mixture for quantiles and densities: every part has an sd of half its own step of the path, too, without which
/// parts that have no other spread are a comb. It adds 3e-4 to an sd at 241 points, and leaves 1.4 % of the comb.
Mixture without_gaps(const Profile& profile);

/// `centre` with squares.
Profile profile(const PathChain& chain, const Centre& centre, const ProfileOptions& options = {});

}  // namespace surveymc::orders
