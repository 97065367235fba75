#pragma once
/// A drawn well's point as a function of its draws (orders/chain.h): the errors of sources through depth, direction and
/// minimum curvature. The normals are the draws of `errors`, in their order.
///
/// The displacement depends on the draws through the four numbers of every station (well_errors.h), and has second
/// derivatives between neighbouring stations only. These numbers are low rank (errors of several stations) plus blocks
/// (errors of one): time and memory are linear in stations.
#include "orders/chain.h"
#include "propagate/source_moments.h"
#include "propagate/well_errors.h"

namespace surveymc::propagate {

class WellChain final : public orders::Chain {
 public:
  /// `errors` must outlive this.
  WellChain(const WellErrors& errors, const WellPoint& point);

  Eigen::Index dimension() const override { return static_cast<Eigen::Index>(errors_.draws.size()); }
  Eigen::Matrix3Xd values(const Eigen::MatrixXd& z) const override;
  orders::Path path(const Eigen::VectorXd& v, const std::vector<double>& t) const override;
  orders::Expansion expand(const Eigen::VectorXd& z, const Eigen::VectorXd& state,
                           const orders::ExpansionParts& parts) const override;

 private:
  double share(std::size_t station) const { return station == point_.station ? point_.share : 1; }
  /// dD, dI, dA, tau of every station by the draws: 4 a station.
  Eigen::VectorXd numbers(const Eigen::VectorXd& z) const;
  Eigen::Vector3d course(const Eigen::VectorXd& z) const;
  Eigen::Vector3d displacement(const Eigen::VectorXd& numbers) const;
  /// Covariance of the numbers of the stations k - 1 and k.
  Eigen::Matrix<double, 8, 8> pair(std::size_t k) const;

  const WellErrors& errors_;
  WellPoint point_;
  std::vector<LegGeometry> legs_;          ///< of every station from 1 on
  std::vector<Eigen::Vector3d> true_leg_;  ///< their displacement without errors
  Eigen::MatrixXd lasting_;                ///< 4 stations x draws of several stations
  std::vector<Eigen::Matrix4d> own_;       ///< covariance by the draws of one station
};

/// Mean to second order and covariance to fourth (orders/second.h).
PointMoments second_order_moments(const WellErrors& errors, const WellPoint& point);

}  // namespace surveymc::propagate
