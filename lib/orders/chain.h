#pragma once
/// What a run does to a position, as a function of the standard normals that it is made of: F(z), the error of the
/// position (N, E, V, m) in a run with the normals z. All predictions beyond first order (second.h, sigma_points.h,
/// profile.h) are made of values and expansions of F.
#include <array>
#include <vector>

#include <Eigen/Core>

namespace surveymc::orders {

/// F along a line, one column a point. `states`: what expand() needs to know of the point, for instance the estimate;
/// no rows where it is nothing. A point without a value has NaN.
struct Path {
  Eigen::Matrix3Xd at;
  Eigen::MatrixXd states;
};

/// Derivatives of F at a point, by all normals. With d normals: J = dF/dz, H_a = second derivatives of F_a.
struct Expansion {
  Eigen::Matrix3Xd first;                ///< J, 3 x d, m
  Eigen::Vector3d trace;                 ///< tr H_a
  std::array<Eigen::MatrixXd, 3> along;  ///< H_a V, d x directions
  Eigen::Matrix3d squares = {};          ///< tr(H_a H_b), where asked for
};

/// Which derivatives are wanted beside J and the trace.
struct ExpansionParts {
  Eigen::MatrixXd directions = {};  ///< V, d x directions; none: no columns
  bool squares = false;
};

/// What a profile needs to know of F.
class PathChain {
 public:
  virtual ~PathChain() = default;
  virtual Eigen::Index dimension() const = 0;
  /// F(t v) for rising t. Where F has several branches (a second minimum of an estimate), that of the lower cost:
  /// every point is sought from the truth and from its neighbours.
  virtual Path path(const Eigen::VectorXd& v, const std::vector<double>& t) const = 0;
  /// At z, on the branch of `state` (that of a point near by). Memory is linear in d.
  virtual Expansion expand(const Eigen::VectorXd& z, const Eigen::VectorXd& state,
                           const ExpansionParts& parts) const = 0;
};

class Chain : public PathChain {
 public:
  /// F at every column of z. NaN where it has no value.
  virtual Eigen::Matrix3Xd values(const Eigen::MatrixXd& z) const = 0;
};

/// Mean and covariance of the error of a position, N, E, V: m, m2.
struct Moments {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// F and its derivatives at z = 0.
struct Centre {
  Eigen::Vector3d value;
  Eigen::VectorXd state;
  Expansion expansion;
};
Centre centre_of(const PathChain& chain, const ExpansionParts& parts);

/// F(0) and J J'.
Moments first_order(const Centre& centre);

}  // namespace surveymc::orders
