#pragma once
/// A chain that is known by its values alone: its derivatives are central differences.
///   dF/dz_i        (8 (F(h) - F(-h)) - (F(2h) - F(-2h))) / 12 h
///   d2F/dz_i2      (16 (F(h) + F(-h)) - (F(2h) + F(-2h)) - 30 F) / 12 h2
///   d2F/dz_i dz_j  (F(h, h) + F(-h, -h) - F(h) - F(-h) of i and of j + 2 F) / 2 h2
/// An expansion takes 4 d values, 4 d more for each direction, and d (d - 1) more for the squares. Right to some 1e-4
/// of second derivatives where F is smooth over a tenth of a normal.
#include <functional>

#include "orders/chain.h"

namespace surveymc::orders {

class DifferenceChain final : public Chain {
 public:
  /// F at every column of z. NaN where it has no value. May be asked for many columns, in batches.
  using Values = std::function<Eigen::Matrix3Xd(const Eigen::MatrixXd& z)>;
  DifferenceChain(Eigen::Index dimension, Values values) : dimension_(dimension), values_(std::move(values)) {}

  Eigen::Index dimension() const override { return dimension_; }
  Eigen::Matrix3Xd values(const Eigen::MatrixXd& z) const override { return values_(z); }
  /// Without states. Each point is on the branch that its value is on.
  Path path(const Eigen::VectorXd& v, const std::vector<double>& t) const override;
  Expansion expand(const Eigen::VectorXd& z, const Eigen::VectorXd& state, const ExpansionParts& parts) const override;

 private:
  Eigen::Index dimension_;
  Values values_;
};

}  // namespace surveymc::orders
